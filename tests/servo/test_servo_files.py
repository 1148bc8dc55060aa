"""The servo's sections of a robot file: typed, bounded, with a reason for every bound."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from deltactl.firmware_py.controller.build import build_controller
from deltactl.firmware_py.install.wiring import wiring
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.errors import ConfigError
from deltactl.models.dynamics import mass_matrix_kgm2
from deltactl.models.linkage import Linkage, inverse
from deltactl.models.robot_files import load_delta

MICRO = Path(__file__).resolve().parents[2] / "config" / "uzunovic-2013.yaml"
TEXT = MICRO.read_text(encoding="utf-8")
FAULT = "as_built: {servo: {faults: [{kind: encoder_lost, joint: 2, at_s: 3}]}}\n"
STEPPER = "drive: {microsteps_per_rev: 1600, gear_ratio: 10}\n"

WRONG = [
    ("gear_ratio: 14", "gear_ratio: 0", "drive.gear_ratio: .* greater than 0.*turns per arm turn"),
    ("gear_ratio: 14", "gear_rato: 14", "drive.gear_rato: unknown key; did you mean 'gear_ratio'"),
    ("kind: servo", "kind: sevro", "drive.kind: must be one of stepper, servo"),
    ("torque_constant_nmpa: 0.0079", "torque_constant_nmpa: 0", "without torque nothing moves"),
    ("rotor_inertia_kgm2: 5.4e-8", "rotor_inertia_kgm2: 54", "is a flywheel"),
    ("nominal_inertia_kgm2: 1.8e-7", "nominal_inertia_kgm2: 5.0e-8", "must not be below rotor"),
    ("current_limit_a: 0.8", "current_limit_a: -1", "drive.current_limit_a: .*nothing moves"),
    ("encoder_deg: 0.01", "encoder_deg: '0.01'", "drive.encoder_deg: .* valid number"),
    ("encoder_deg: 0.01", "", "drive: 'encoder_deg' is missing"),
    ("loop_rate_hz: 10000", "loop_rate_hz: 500", "slower is no current loop"),
    ("loop_rate_hz: 10000", "loop_rate_hz: 10500", "must be a whole number of kHz"),
    ("loop_rate_hz: 10000", "loop_rate_hz: 2000", "velocity_bandwidth_radps is too fast"),
    ("velocity_bandwidth_radps: 3500", "velocity_bandwidth_radps: 100", "must not exceed velocity"),
    ("brake: holding", "brake: hand", "drive.brake: .*'holding' or 'none'"),
    ("following_error_deg: 2.0", "following_error_deg: 0", "it follows nothing"),
]


def write(folder: Path, text: str) -> Path:
    path = folder / "robot.yaml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize(("was", "becomes", "says"), WRONG)
def test_a_mistake_is_one_line_that_names_the_key(
    tmp_path: Path, was: str, becomes: str, says: str
) -> None:
    assert TEXT.count(was) == 1
    with pytest.raises(ConfigError, match=says) as caught:
        load_robot(write(tmp_path, TEXT.replace(was, becomes)))
    assert "\n" not in str(caught.value)
    assert "robot.yaml:" in str(caught.value)


def test_currents_need_masses_to_carry(tmp_path: Path) -> None:
    text = "\n".join(line for line in TEXT.splitlines() if not line.startswith("masses:"))
    with pytest.raises(ConfigError, match="kind servo needs a 'masses' section"):
        load_robot(write(tmp_path, text))


def test_faults_to_come_are_read_and_belong_to_servos_only(tmp_path: Path) -> None:
    robot = load_robot(write(tmp_path, TEXT + FAULT))
    assert robot.as_built.servo is not None
    assert robot.as_built.servo.faults[0].joint == 2
    with pytest.raises(ConfigError, match=r"joint: .*a delta has three joints"):
        load_robot(write(tmp_path, TEXT + FAULT.replace("joint: 2", "joint: 4")))
    start, end = TEXT.index("drive:"), TEXT.index("# The paper measures")
    stepper = TEXT[:start] + STEPPER + TEXT[end:] + FAULT
    with pytest.raises(ConfigError, match=r"only robots with drive\.kind servo"):
        load_robot(write(tmp_path, stepper))


def test_the_diagnosis_reads_the_file_too() -> None:
    robot = load_delta(MICRO)
    assert robot.drive is not None
    assert robot.drive.kind == "servo"


@pytest.mark.study
def test_there_is_no_driver_for_real_drives_and_that_is_said(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="no driver for real servo drives"):
        build_controller(MICRO, simulated=False, realtime=True, recordings=tmp_path)


def test_a_servo_robot_has_no_step_lines_to_wire(micro) -> None:
    signals = {wire.signal for wire in wiring(micro)}
    assert not any(signal.startswith(("STEP", "DIR", "ENA", "ALM")) for signal in signals)
    assert "E-STOP" in signals


def test_the_nominal_inertia_is_that_of_the_paper_s_cube(micro, drive) -> None:
    """m_jjn of equation 4 against M_jj of equation 3 over the 10 mm cube."""
    linkage = Linkage.of(micro.geometry)
    sides = np.array([-0.005, 0.0, 0.005])
    cube = np.stack(np.meshgrid(sides, sides, sides - 0.0758), axis=-1).reshape(-1, 3)
    angles = inverse(linkage, cube).angles_rad
    matrix = mass_matrix_kgm2(linkage, micro.masses, angles, cube)
    own = np.einsum("nii->ni", matrix) / drive.gear_ratio**2 + drive.rotor_inertia_kgm2
    assert np.median(own) == pytest.approx(drive.nominal_inertia_kgm2, rel=0.02)
    assert own.min() / drive.nominal_inertia_kgm2 > 0.9
    assert own.max() / drive.nominal_inertia_kgm2 < 1.1
