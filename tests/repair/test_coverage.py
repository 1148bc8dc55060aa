"""What a job says of each effect that the robot file believes in."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.planning.prepared import InForce, prepare_here
from deltactl.firmware_py.program.coverage import coverage_of, robot_coverage
from deltactl.firmware_py.program.totals import check_job
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.errors import ConfigError
from deltactl.models.calibrated_inverse import CalibratedInverse
from deltactl.models.chain import Chain, Commands
from deltactl.models.effects import TABLES, VOCABULARY, Compensated, EffectCard, card_of
from deltactl.models.robot import EffectEntry

ROBOT = (CONFIG_FOLDER / "zhao-2023.yaml").read_text()
EFFECTS = """
effects:
- {effect: home_offset, component: motor1, parameters: {angle: 0.01}}
- {effect: joint_friction, component: motor2, parameters: {width: 0.004}}
- {effect: resonance, component: platform, parameters: {frequency: 5.0, damping: 0.1}}
- {effect: contact, component: platform, parameters: {height: -0.6}}
"""


@pytest.fixture
def corrected(tmp_path: Path) -> Path:
    path = tmp_path / "corrected.yaml"
    path.write_text(ROBOT + EFFECTS)
    return path


def test_a_network_that_does_not_know_is_a_warning_and_geometry_knows(
    corrected: Path, tmp_path: Path
) -> None:
    heart = CONFIG_FOLDER / "heart.yaml"
    by_network = coverage_of(heart, corrected)
    assert "home_offset on motor1" in by_network.warning
    assert f"deltactl network train --robot {corrected}" in by_network.warning
    assert {one.effect for one in by_network.left} == {"home_offset", "contact"}
    job = tmp_path / "heart.yaml"
    job.write_text(
        heart.read_text().replace("network  ", "geometry").replace("file: zhao-2023.tflite", "")
    )
    by_geometry = coverage_of(job, corrected)
    assert by_geometry.warning == ""
    assert [one.effect for one in by_geometry.left] == ["contact"]
    assert coverage_of(heart).effects == ()


def test_an_included_job_brings_its_own_network(corrected: Path, tmp_path: Path) -> None:
    job = tmp_path / "both.yaml"
    job.write_text(
        "name: both\nrobot: zhao-2023.yaml\ntiming: {mode: together, t_pwm_s: 0.006}\n"
        "inverse_kinematics: {kind: geometry}\nsteps:\n- include: demo-heart.yaml\n"
        "- include: heart.yaml\n"
    )
    both = coverage_of(job, corrected)
    assert "home_offset on motor1" in both.warning
    assert {one.effect for one in both.left} == {"home_offset", "contact"}


def test_a_path_in_arm_angles_is_commanded_as_it_is(corrected: Path) -> None:
    assert coverage_of(CONFIG_FOLDER / "survey.yaml", corrected).compensated == ()


def test_motors_that_step_together_only_cannot_be_led(corrected: Path) -> None:
    robot = load_robot(corrected)
    steps = robot.steps.model_copy(update={"backend": "gpiozero"})
    left = robot_coverage(robot.model_copy(update={"steps": steps})).left
    assert {one.effect: "gpiozero" in one.why_not for one in left} == {
        "resonance": True,
        "contact": False,
    }
    assert "resonance" in {one.effect for one in robot_coverage(robot).compensated}


def test_every_effect_of_the_vocabulary_has_its_words() -> None:
    for name in (*VOCABULARY, *TABLES):
        card = card_of(name)
        assert (card.compensated is Compensated.NOT) == (card.left != EffectCard(name).left), name


def test_a_job_runs_on_the_corrected_file_of_its_machine_only(
    corrected: Path, tmp_path: Path
) -> None:
    heart = CONFIG_FOLDER / "heart.yaml"
    robot = load_robot(corrected)
    in_force = InForce(robot, corrected, corrected.read_text())
    assert prepare_here(heart, in_force).plan.robot is robot
    other = tmp_path / "other.yaml"
    other.write_text(ROBOT.replace("gear_ratio: 10 ", "gear_ratio: 12 "))
    with pytest.raises(ConfigError, match="is for robot file"):
        prepare_here(heart, InForce(load_robot(other), other, other.read_text()))
    assert check_job(heart, robot_file=corrected).robot == "zhao-2023"


def test_what_a_corrected_robot_is_believed_to_do_is_what_its_chain_does(corrected: Path) -> None:
    robot = load_robot(corrected).model_copy(
        update={
            "effects": tuple(
                EffectEntry(effect=effect, component=component, parameters=values)
                for effect, component, values in (
                    ("gear_ratio", "motor1", {"scale": 1.01}),
                    ("transmission_error", "motor2", {"amplitude": 0.002, "period": 0.6}),
                    ("upper_arm_length", "arm3", {"length_error": 0.002}),
                )
            )
        }
    )
    angles_rad = np.deg2rad([[10.0, 20.0, 30.0], [40.0, 45.0, 50.0]])
    expected = Chain(robot).simulate(Commands.of_angles(np.arange(2.0), angles_rad)).position
    inverse = CalibratedInverse(robot)
    np.testing.assert_allclose(inverse.position_m(angles_rad), expected, atol=1e-12)
    np.testing.assert_allclose(inverse.angles_rad_many(expected), angles_rad, atol=1e-8)
