"""Geometry with known effects, turned round: for calibrations and for jobs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from deltactl.firmware_py.job_file import JobFile, load_job
from deltactl.firmware_py.job_targets import kinematics_of
from deltactl.firmware_py.named_files import find
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.errors import ConfigError, RecordingError, UnreachablePoint
from deltactl.models.calibrated_inverse import CalibratedInverse
from deltactl.models.chain.commands import Commands
from deltactl.models.chain.delta import Chain
from deltactl.models.inverse_kinematics import GeometricInverse
from deltactl.models.linkage import Linkage, forward
from deltactl.models.robot import DeltaRobot, EffectEntry

ROBOT = load_robot(find("zhao-2023.yaml"))
TARGETS_M = np.array([[0.0, 0.0, -0.45], [0.1, -0.05, -0.4], [-0.12, 0.08, -0.55]])


def entry(effect: str, component: str, **parameters: float) -> EffectEntry:
    return EffectEntry(effect=effect, component=component, parameters=dict(parameters))


EFFECTS = (
    entry("home_offset", "motor1", angle=0.2),
    entry("gear_ratio", "motor2", scale=1.01),
    entry("transmission_error", "motor3", amplitude=0.002, period=0.6283, phase=0.4),
    entry("joint_compliance", "joints", stiffness=400.0),
    entry("forearm_length", "arm2", length_error=0.004),
    entry("upper_arm_length", "arm3", length_error=-0.002),
    entry("base_radius", "frame", length_error=0.003),
    entry("motor_azimuth", "motor2", angle=0.02),
    entry("sensor_offset", "range_z", offset=0.01),
    entry("gear_backlash", "motor1", width=0.004),
)


def with_effects(*effects: EffectEntry) -> DeltaRobot:
    return ROBOT.model_copy(update={"effects": effects})


@pytest.mark.parametrize("effect", EFFECTS[:8], ids=lambda effect: effect.effect)
def test_the_chain_ends_where_it_was_asked(effect: EffectEntry) -> None:
    robot = with_effects(effect)
    angles_rad = CalibratedInverse(robot).angles_rad_many(TARGETS_M)
    reached_m = Chain(robot).simulate(Commands.of_angles(np.arange(3.0), angles_rad)).position
    assert np.abs(reached_m - TARGETS_M).max() < 1e-8
    plain_rad = GeometricInverse(ROBOT.geometry).angles_rad_many(TARGETS_M)
    assert np.abs(angles_rad - plain_rad).max() > 1e-4


def test_all_at_once_and_one_by_one_agree() -> None:
    inverse = CalibratedInverse(with_effects(*EFFECTS))
    each = [inverse.angles_rad(*target) for target in TARGETS_M.tolist()]
    assert np.array_equal(inverse.angles_rad_many(TARGETS_M), each)
    assert np.allclose(inverse.angles_rad_at_once(TARGETS_M), each, atol=1e-9)


def test_sensors_and_memory_have_no_part_in_it() -> None:
    inverse = CalibratedInverse(with_effects(*EFFECTS[8:]))
    assert inverse.effects == ()
    plain = GeometricInverse(ROBOT.geometry).angles_rad_many(TARGETS_M)
    assert np.array_equal(inverse.angles_rad_many(TARGETS_M), plain)


def test_out_of_reach_is_said() -> None:
    with pytest.raises(UnreachablePoint):
        CalibratedInverse(with_effects(*EFFECTS)).angles_rad(0.0, 0.0, -0.9)


def job(kind: str) -> JobFile:
    shipped = load_job(find("circle.yaml"))
    data = shipped.model_dump(mode="json") | {"inverse_kinematics": {"kind": kind}}
    return JobFile.model_validate_json(__import__("json").dumps(data))


def test_jobs_take_known_effects_into_account() -> None:
    robot = ROBOT.model_copy(update={"effects": EFFECTS})
    for kind in ("geometry", "calibrated"):
        assert isinstance(kinematics_of(job(kind), robot, None), CalibratedInverse)
    assert isinstance(kinematics_of(job("geometry"), ROBOT, None), GeometricInverse)
    with pytest.raises(ConfigError, match="no effects"):
        kinematics_of(job("calibrated"), ROBOT, None)


@pytest.mark.study
def test_a_calibration_is_the_robot_file_it_is_written_to(surveyed: Path, tmp_path: Path) -> None:
    pytest.importorskip("scipy", reason="calibrating needs the extra 'training'")
    from deltactl.models.training.calibrate import calibrate
    from deltactl.models.training.calibrated_file import check_new, save_calibrated
    from deltactl.models.training.dataset import load_dataset

    data = load_dataset(surveyed)
    found = calibrate(ROBOT, data.position_m, data.angles_rad)
    path = tmp_path / "calibrated.yaml"
    save_calibrated(find("zhao-2023.yaml"), found, "120 samples", "as-built", path)
    robot = load_robot(path)
    assert robot.calibrated_on == "as-built"
    bare = tmp_path / "bare.yaml"
    bare.write_text(path.read_text().split("effects:")[0])
    for calibrated in (path, bare):  # a calibration of a calibration would be of no design
        with pytest.raises(RecordingError, match="calibration already"):
            check_new(calibrated, tmp_path / "new.yaml")
    inverse = CalibratedInverse(robot)
    apart_rad = inverse.angles_rad_at_once(TARGETS_M) - found.angles_rad_many(TARGETS_M)
    assert np.degrees(np.abs(apart_rad)).max() < 0.0225  # one microstep
    assert robot.sensors is not None
    outputs = Chain(robot).simulate(Commands.of_angles(np.arange(len(data)), data.angles_rad))
    misfit_m = outputs.ranges - robot.sensors.offsets_m - data.position_m
    assert np.sqrt(np.mean(misfit_m**2)) < 1.2e-3
    nominal_m = forward(Linkage.of(ROBOT.geometry), data.angles_rad).position_m
    assert np.sqrt(np.mean((nominal_m - data.position_m) ** 2)) > 20e-3
