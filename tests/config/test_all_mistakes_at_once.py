"""All mistakes of a file in one round, each with file and line."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from deltactl.firmware_py.job_file import load_job
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.program.totals import check_job
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.errors import ConfigError
from deltactl.models.robot_files import load_with_effects

ZHAO = (CONFIG_FOLDER / "zhao-2023.yaml").read_text(encoding="utf-8")
PICK = (CONFIG_FOLDER / "pick.yaml").read_text(encoding="utf-8")


def told(path: Path, text: str, read) -> list[str]:
    """The lines that refuse a text, without the folder."""
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError) as error:
        read(path)
    assert all(re.match(rf"{re.escape(str(path))}:\d+: ", line) for line in error.value.args)
    return [line.removeprefix(str(path)) for line in error.value.args]


def without(text: str, section: str) -> str:
    return re.sub(rf"^{section}:.*\n(?:  .*\n)+", "", text, flags=re.MULTILINE)


def test_keys_that_contradict_each_other_beside_one_that_is_wrong(tmp_path: Path) -> None:
    text = without(without(ZHAO, "limits"), "homing")
    text += "limits:\n  arm_deg: [90, -20]\n  joint_speed_radps: -3\n"
    text += "homing:\n  method: switch\n  speed_radps: 9\n"
    said = "\n".join(told(tmp_path / "robot.yaml", text, load_robot))
    for one in (
        "limits: arm_deg must be [lowest, highest]", "limits.joint_speed_radps:",
        "homing: method 'switch' needs switch_pins", "homing.speed_radps:",
    ):  # fmt: skip
        assert one in said
    assert len(said.splitlines()) == 4


@pytest.mark.parametrize("pins", ["[7, 8, 99]", "[7, 8]"])
def test_what_follows_from_a_mistake_is_not_told_beside_it(tmp_path: Path, pins: str) -> None:
    text = without(ZHAO, "homing") + f"homing: {{method: switch, switch_pins: {pins}}}\n"
    (said,) = told(tmp_path / "robot.yaml", text, load_robot)
    assert "switch_pins" in said


def test_a_misspelt_key_is_not_told_as_missing(tmp_path: Path) -> None:
    text = without(ZHAO, "homing") + "homing: {method: switch, swich_pins: [1, 7, 8]}\n"
    (said,) = told(tmp_path / "robot.yaml", text, load_robot)
    assert "did you mean 'switch_pins'" in said


TWO = [
    ("kind: range_sensor\nname: s\n", "sensor_offset"),
    ("kind: stepper_axis\nname: s\n", "gear_backlash"),
    ("kind: servo_axis\nname: s\nmotion: linear\n", "home_offset"),
]


@pytest.mark.parametrize(("head", "known"), TWO)
def test_wrong_effects_of_a_lone_machine(tmp_path: Path, head: str, known: str) -> None:
    text = head + (
        "effects:\n  - {effect: payload, component: axis, parameters: {mass: 1}}\n"
        f"  - {{effect: {known}, component: motor1, parameters: {{x: 1}}}}\n"
    )
    first, second = told(tmp_path / "robot.yaml", text, load_with_effects)
    line = text.splitlines().index("effects:") + 2
    assert first.startswith(f":{line}: effects.0: effect 'payload' must be one of ")
    assert second.startswith(f":{line + 1}: effects.1: effect {known}: component 'motor1'")
    again = told(tmp_path / "robot.yaml", text.replace("name: s", "nam: s"), load_with_effects)
    assert len(again) == 3


def test_an_axis_that_slides_is_told_the_names_of_its_file(tmp_path: Path) -> None:
    text = "kind: servo_axis\nname: s\nmotion: linear\neffects:\n"
    text += "  - {effect: home_offset, component: axis, parameters: {ofset: 1}}\n"
    (said,) = told(tmp_path / "robot.yaml", text, load_with_effects)
    assert "parameter 'ofset' must be one of offset" in said


@pytest.mark.parametrize("friction", ["width: 0.001", "force: 3", "torque: 3"])
def test_friction_of_an_axis_may_be_a_width_or_a_force(tmp_path: Path, friction: str) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text(
        "kind: servo_axis\nname: s\nmotion: linear\neffects:\n"
        f"  - {{effect: joint_friction, component: axis, parameters: {{{friction}}}}}\n"
    )
    assert load_with_effects(path).effects[0].effect == "joint_friction"


def test_effects_as_built_beside_other_mistakes(tmp_path: Path) -> None:
    text = ZHAO.replace("forearm_m: 0.5", "forarm_m: 0.5")
    text += "as_built: {effects: [{effect: play, component: motor1}]}\n"
    said = told(tmp_path / "robot.yaml", text, load_robot)
    assert len(said) == 2
    assert "as_built.effects.0: effect 'play' must be one of" in said[1]


def test_outputs_inputs_and_includes_beside_other_mistakes_of_a_job(tmp_path: Path) -> None:
    text = PICK.replace("gripper: on", "griper: on") + (
        "  - wait_for: {input: part, within_s: 1}\n  - include: picks.yaml\n"
        "  - repeat: 2\n    steps: [{set: {valve: on}}]\n  - wait_s: -1\n"
    )
    names = (
        "steps.1.set: 'griper' is not in 'outputs' of robot 'gripper-delta'; did you mean",
        "wait_for: 'part' is not in 'inputs.named'",
        "include: picks.yaml: no such file beside",
        "steps.0.set: 'valve' is not in 'outputs'",
    )
    for wrong in ("wait_s: -1", "wait_s: 1"):
        said = told(tmp_path / "job.yaml", text.replace("wait_s: -1", wrong), check_job)
        assert [one for one in names if one not in "\n".join(said)] == []
        assert len(said) == len(names) + ("-1" in wrong)


def test_a_spiral_that_is_wrong_in_two_ways(tmp_path: Path) -> None:
    text = (CONFIG_FOLDER / "spiral.yaml").read_text(encoding="utf-8")
    text = re.sub(r"outer_radius_m: \S+", "outer_radius_m: 0.01", text)
    text = re.sub(r"spacing_m: \S+", "spacing_m: 1", text)
    assert len(told(tmp_path / "job.yaml", text, load_job)) == 2


def test_mistakes_within_a_repeat_are_told_where_they_stand(tmp_path: Path) -> None:
    """The key `repeat` names the step, and stands beside the steps that it repeats."""
    path = tmp_path / "job.yaml"
    path.write_text(
        "name: j\nrobot: zhao-2023.yaml\ntiming: {mode: accelerated, speed_mps: 0.1}\n"
        "inverse_kinematics: {kind: geometry}\nsteps:\n  - repeat: 2\n    steps:\n"
        "      - path:\n          shape: way\n          start_m: [0.05, 0.05, -0.45]\n"
        "          corner_mm: 0.002\n          legs: [{to_m: [0.05, -0.05, -450]}]\n"
        "      - wait: 0.2\n"
    )
    with pytest.raises(ConfigError) as error:
        load_job(path)
    assert [one.removeprefix(f"{path}:") for one in error.value.args] == [
        "11: steps.0.steps.0.path.corner_mm: unknown key; did you mean 'corner_m'?",
        "12: steps.0.steps.0.path.legs.0.to_m.2: this is in metres, not in mm: write -0.45",
        "13: steps.0.steps.1.wait: unknown key; did you mean 'wait_s'?",
    ]
