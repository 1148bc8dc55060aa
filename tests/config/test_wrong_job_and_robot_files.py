"""Mistakes people make in robot and job files: each is one line with file, line and key."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from deltactl.firmware_py.controller.build import build_controller
from deltactl.firmware_py.job_file import load_job
from deltactl.firmware_py.named_files import CONFIG_FOLDER, JOB_KEY, ROBOT_KEY, find
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.errors import ConfigError, MissingFile

HEART = (CONFIG_FOLDER / "heart.yaml").read_text(encoding="utf-8")
ZHAO = (CONFIG_FOLDER / "zhao-2023.yaml").read_text(encoding="utf-8")
MICRO = (CONFIG_FOLDER / "micro-circle.yaml").read_text(encoding="utf-8")
SPIRAL = (CONFIG_FOLDER / "spiral.yaml").read_text(encoding="utf-8")
SURVEY = (CONFIG_FOLDER / "survey.yaml").read_text(encoding="utf-8")

WRONG_JOBS = [
    (HEART, "width_m: 0.2", "widht_m: 0.2", "path.widht_m: unknown key; did you mean 'width_m'?"),
    (HEART, "width_m: 0.2", "width_m: 0.2 m", "path.width_m: Input should be a valid number"),
    (HEART, "width_m: 0.2", "width_m: -0.2", "path.width_m: Input should be greater than 0"),
    (
        HEART,
        "width_m: 0.2",
        "width_m: 200",
        "path.width_m: this is in metres, not in mm",
    ),
    (HEART, "width_m: 0.2", "width_m: .inf", "path.width_m: must be a finite number"),
    (HEART, "shape: heart", "shape: hart", "path.shape: must be one of circle, heart, spiral"),
    (HEART, "shape: heart", "sharp: heart", "'shape' is missing"),
    (HEART, "turns: 1", "turns: 0", "path.turns: Input should be greater than or equal to 1"),
    (HEART, "turns: 1", "turns: 1000", "path: the path has 1,277,094 targets, and 1,000,000"),
    (HEART, "[0.0, 0.0, -0.45]", "[0.0, -0.45]", "path.centre_m: item 3 is missing"),
    (
        HEART,
        "[0.0, 0.0, -0.45]",
        "[0, 0, -450]",
        "path.centre_m.2: this is in metres, not in mm",
    ),
    (HEART, "t_pwm_s: 0.006", "t_pwm_s: 0.00004", "timing.t_pwm_s: Input should be greater"),
    (HEART, "t_pwm_s: 0.006", "t_pwm: 0.006", "timing.t_pwm: unknown key; did you mean 't_pwm_s'?"),
    (HEART, "mode: together", "mode: slow", "timing.mode: must be one of together, accelerated"),
    (HEART, "kind: network", "kind: guess", "inverse_kinematics.kind: must be one of geometry"),
    (HEART, "  file: zhao", "  fiel: zhao", "inverse_kinematics.fiel: unknown key; did you mean"),
    (HEART, "repeats: 1", "repeats: 0", "repeats: Input should be greater than or equal to 1"),
    (HEART, "repeats: 1", "repeats: 2.5", "repeats: Input should be a valid integer"),
    (HEART, "repeats: 1", "repeats: yes", "repeats: Input should be a valid integer"),
    (HEART, "repeats: 1", "repeat: 1", "repeat: unknown key; did you mean 'repeats'?"),
    (HEART, "repeats: 1", "record: ''", "record: String should have at least 1 character"),
    (HEART, "repeats: 1", "name: again", "'name' occurs here twice; remove one"),
    (HEART, "name: heart", "name:", "name: Input should be a valid string"),
    (HEART, "robot: zhao-2023.yaml", "", "'robot' is missing"),
    (MICRO, "speed_mps: 0.00377", "speed_mps: 0", "timing.speed_mps: Input should be greater"),
    (
        MICRO,
        "speed_mps",
        "t_pwm_s",
        "timing.t_pwm_s: unknown key here; it belongs to mode tog",
    ),
    (
        HEART,
        "turns: 1",
        "repeats: 1",
        "path.repeats: unknown key here; it belongs at the top l",
    ),
    (HEART, "repeats: 1", "t_pwm_s: 1", "t_pwm_s: unknown key here; it belongs in 'timing'"),
    (MICRO, "turns: 5", "turns: 0", "path: turns must not be 0"),
    (SPIRAL, "outer_radius_m: 0.12", "outer_radius_m: 0.02", "outer_radius_m must be larger"),
    (SURVEY, "[-20, 110]", "[110, -20]", "path: angle_deg must be [lowest, highest]"),
    (SURVEY, "count: 100", "count: 2000000", "path.count: Input should be less than or equal"),
    (SURVEY, "dwell_s: 0.5", "dwell_s: 7200", "path.dwell_s: Input should be less than or equal"),
]

WRONG_ROBOTS = [
    (
        "base_radius_m: 0.325",
        "base_radius_m: 325",
        "geometry.base_radius_m: this is in metres, not in mm",
    ),
    ("forearm_m: 0.5", "forarm_m: 0.5", "geometry.forarm_m: unknown key; did you mean 'forearm_m'"),
    ("[0, 120, 240]", "[0, 120]", "geometry.azimuth_deg: item 3 is missing"),
    ("kind: delta", "kind: scara", "kind: must be 'delta' (got 'scara')"),
    ("kind: delta", "kind: servo_axis", "kind: cannot be run, only diagnosed"),
    ("gear_ratio: 10", "gear_ratio: 0", "drive.gear_ratio: Input should be greater than 0"),
    ("per_rev: 1600", "per_rev: 1600.5", "drive.microsteps_per_rev: Input should be a valid int"),
    ("[17, 27, 22]", "[17, 17, 22]", "steps.step_pins: GPIO 17 is taken by steps.step_pins"),
    ("[17, 27, 22]", "[17, 40, 22]", "steps.step_pins.1: Input should be less than or equal to 27"),
    ("estop_pin: 26", "estop_pin: 17", "inputs.estop_pin: GPIO 17 is taken by steps.step_pins"),
    ("[4, 20, 21]", "[2, 20, 21]", "ranging.xshut_pins: GPIO 2 is taken by the I2C bus already"),
    ("axis: [1, 0, 0]", "axis: [1, 1, 0]", "sensors.x: axis must be a direction of length 1"),
    ("arm_deg: [-20, 110]", "arm_deg: [110, -20]", "limits: arm_deg must be [lowest, highest]"),
    ("[30, 30, 30]", "[30, 30, 130]", "homing.angle_deg: 130 is outside limits.arm_deg [-20, 110]"),
    ("masses:", "mases:", "mases: unknown key; did you mean 'masses'?"),
    ("step_rate_hz", "step_rate", "limits.step_rate: unknown key; did you mean 'step_rate_hz'?"),
    ("step_rate_hz: 20000", "step_rate_hz: 1e6", "limits.step_rate_hz: Input should be less than"),
    ("method: placed", "method: switch", "homing: method 'switch' needs switch_pins"),
    (
        "limits:",
        "limits:\n  box_m: [[0, 1], [1, 0], [0, 1]]",
        "limits: box_m must be three pairs of [lowest, highest]",
    ),
    (
        "masses:",
        "as_built: {effects: [{efect: gear_backlash, component: motor1}]}\nmasses:",
        "as_built.effects.0.efect: unknown key; did you mean 'effect'?",
    ),
]


def refusal(path: Path, load: Callable[[Path], object], text: str) -> str:
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError) as error:
        load(path)
    return str(error.value)


@pytest.mark.parametrize(("text", "right", "wrong", "says"), WRONG_JOBS)
def test_a_mistake_in_a_job_is_one_line(tmp_path, text, right, wrong, says):
    assert right in text
    message = refusal(tmp_path / "job.yaml", load_job, text.replace(right, wrong, 1))
    check(message, tmp_path / "job.yaml", says)


@pytest.mark.parametrize(("right", "wrong", "says"), WRONG_ROBOTS)
def test_a_mistake_in_a_robot_is_one_line(tmp_path, right, wrong, says):
    assert right in ZHAO
    message = refusal(tmp_path / "robot.yaml", load_robot, ZHAO.replace(right, wrong, 1))
    check(message, tmp_path / "robot.yaml", says)


def check(message: str, path: Path, says: str) -> None:
    assert "\n" not in message
    assert says in message
    place, number, rest = message.removeprefix(str(path)).split(":", 2)
    assert place == ""
    line = path.read_text(encoding="utf-8").splitlines()[int(number) - 1]
    keys = [key for key in rest.split(": ")[0].strip().split(".") if not key.isdigit()]
    if int(number) > 1:
        assert keys[-1].split("'")[-1].split()[0] in line or keys[-1].split("'")[1] in line


def test_an_empty_file_and_one_that_is_no_yaml(tmp_path):
    assert "job.yaml:1:" in refusal(tmp_path / "job.yaml", load_job, "")
    assert "is not YAML" in refusal(tmp_path / "job.yaml", load_job, "name: [a\nrobot: b")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("path:\n  a: 1\nik: {kind: b}\n  repeats: 3\n", ":4: .* indented otherwise"),
        ("path: 1\n  repeats: 3\n", ":2: .* indented too far"),
        ("path: {a: 1}\n\trepeats: 3\n", ":2: .* with spaces"),
        ("path:\n  a: 1\n\tb: 3\n", ":3: .* with spaces"),
    ],
)
def test_of_broken_yaml_it_says_what_is_behind_it(tmp_path: Path, text: str, says: str) -> None:
    assert re.search(says, refusal(tmp_path / "job.yaml", load_job, text), re.IGNORECASE)


def test_a_ratio_of_two_numbers_is_told_as_one(tmp_path: Path) -> None:
    text = re.sub(r"gear_ratio: \S+", "gear_ratio: 3:2", ZHAO)
    assert "a ratio is one number, 1.5" in refusal(tmp_path / "robot.yaml", load_robot, text)


def test_a_file_that_is_not_there_lists_those_that_are(tmp_path):
    with pytest.raises(MissingFile) as error:
        find("zhao-2032.yaml", beside=tmp_path / "job.yaml")
    said = str(error.value)
    assert "or in config; did you mean 'zhao-2023.yaml'?" in said
    with pytest.raises(MissingFile, match=r"did you mean 'zhao-2023\.yaml'"):
        find("zhao-2023.yml")
    with pytest.raises(
        MissingFile, match=r"there are circle\.yaml, demo-heart\.yaml, gripper-delta\.yaml"
    ):
        find("q.yaml")
    (tmp_path / "mine.tflite").write_bytes(b"")
    with pytest.raises(MissingFile, match=r"or in models/trained; did you mean 'mine.tflite'\?$"):
        find("mien.tflite", beside=tmp_path / "job.yaml")


def test_a_robot_taken_for_a_job_and_a_job_for_a_robot(tmp_path):
    says = refusal(tmp_path / "job.yaml", load_job, ZHAO)
    assert "kind: describes a robot, and a job is needed here; one says 'robot: job.yaml'" in says
    says = refusal(tmp_path / "robot.yaml", load_robot, HEART)
    assert "this is a job, and a robot file is needed here, such as zhao-2023.yaml" in says


def test_a_table_in_place_of_a_job_or_a_robot_is_told_what_makes_one(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(MissingFile, match=r"there are .*heart\.yaml"):
        find("star.gcode", key=JOB_KEY)
    (tmp_path / "lift.csv").write_text("time,goal\n0,0\n", encoding="utf-8")
    with pytest.raises(ConfigError, match=r"'deltactl convert lift\.csv job\.yaml"):
        find("lift.csv", key=JOB_KEY)
    with pytest.raises(ConfigError, match=r"'deltactl init axis my-robot\.yaml' writes one"):
        find("lift.csv", key=ROBOT_KEY)


def test_named_files_are_sought_beside_the_job_first(tmp_path):
    own = tmp_path / "zhao-2023.yaml"
    own.write_text(ZHAO, encoding="utf-8")
    assert find("zhao-2023.yaml", beside=tmp_path / "job.yaml") == own
    own.unlink()
    assert find("zhao-2023.yaml", beside=tmp_path / "job.yaml") == CONFIG_FOLDER / own.name


def test_all_mistakes_of_a_file_are_listed_at_once(tmp_path):
    text = HEART.replace("width_m: 0.2", "widht_m: 0.2").replace("t_pwm_s: 0.006", "t_pwm_s: 1e-6")
    text = text.replace("repeats: 1", "repeats: 0").replace("robot: zhao-2023.yaml", "")
    (tmp_path / "job.yaml").write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError) as error:
        load_job(tmp_path / "job.yaml")
    said = [line.removeprefix(f"{tmp_path}/job.yaml:") for line in error.value.args]
    assert [line.split(": ")[1].split(" ")[0] for line in said] == [
        "'robot'", "path.widht_m", "timing.t_pwm_s", "repeats",
    ]  # fmt: skip


def test_sections_that_contradict_each_other_are_listed_at_once(tmp_path):
    text = ZHAO.replace("[17, 27, 22]", "[17, 17, 22]").replace("[30, 30, 30]", "[30, 30, 130]")
    (tmp_path / "robot.yaml").write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError) as error:
        load_robot(tmp_path / "robot.yaml")
    assert len(error.value.args) == 2


def test_pins_named_twice_and_unknown_effects_are_listed_with_other_mistakes(tmp_path):
    text = ZHAO.replace("[17, 27, 22]", "[17, 17, 22]").replace("estop_pin: 26", "estop_pin: 2")
    text = text.replace("\nname: zhao-2023", "\nnmae: zhao-2023")
    text += "\noutputs: {gripper: {pin: 22, safe: off, actve_high: yes}}\n"
    text += "effects: [{effect: gear_backlsh, component: motor1, parameters: {width: 0.001}}]\n"
    (tmp_path / "robot.yaml").write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError) as error:
        load_robot(tmp_path / "robot.yaml")
    said = "\n".join(error.value.args)
    for one in (
        "nmae", "outputs.gripper.actve_high", "steps.step_pins: GPIO 17 is taken by steps.step",
        "inputs.estop_pin: GPIO 2 is taken by the I2C bus", "gear_backlsh",
        "outputs.gripper.pin: GPIO 22 is taken by steps.step_pins already",
    ):  # fmt: skip
        assert one in said
    assert len(error.value.args) == 6


CONTRADICTIONS = [
    ("[30, 30, 30]", "[30, 30, 130]", "homing.angle_deg: 130 is outside limits.arm_deg"),
    ("masses:", "as_built: {inputs: {door: on}}\nmasses:", "as_built.inputs.door: is no input of"),
    ("masses:", "as_built: {servo: {}}\nmasses:", "as_built.servo: only robots with drive.kind"),
]


@pytest.mark.parametrize(("right", "wrong", "says"), CONTRADICTIONS)
def test_contradictions_are_listed_with_mistakes_elsewhere(tmp_path, right, wrong, says):
    text = ZHAO.replace(right, wrong, 1).replace("forearm_m: 0.5", "forarm_m: 0.5")
    (tmp_path / "robot.yaml").write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError) as error:
        load_robot(tmp_path / "robot.yaml")
    forearm, other = error.value.args
    assert "forarm_m" in forearm
    assert says in other


def test_a_path_with_a_mistake_does_not_make_a_job_of_steps(tmp_path):
    text = MICRO.replace("turns: 5", "turns: five").replace("speed_mps: 0.00377", "duration_s: 4")
    message = refusal(tmp_path / "job.yaml", load_job, text)
    assert "path.turns: Input should be a valid number" in message
    assert "duration_s" not in message


def test_a_section_with_a_mistake_contradicts_nothing(tmp_path):
    text = ZHAO.replace("[30, 30, 30]", "[30, 30, 130]").replace("[-20, 110]", "[-20, 1100]")
    (tmp_path / "robot.yaml").write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError) as error:
        load_robot(tmp_path / "robot.yaml")
    assert len(error.value.args) == 1


@pytest.mark.parametrize("section", ["steps", "inputs", "ranging", "limits", "homing"])
def test_hardware_wants_its_pins_limits_and_homing_said(tmp_path, section):
    text = re.sub(rf"^{section}:.*\n(?:  .*\n)+", "", ZHAO, flags=re.MULTILINE)
    path = tmp_path / "robot.yaml"
    path.write_text(text, encoding="utf-8")
    robot = load_robot(path)
    assert robot.left_open()
    assert all(key.startswith(f"{section}.") for key in robot.left_open())
    build_controller(path, simulated=True, realtime=False, recordings=tmp_path).close()
    with pytest.raises(ConfigError, match=rf"simulated only: its file does not say {section}\."):
        build_controller(path, simulated=False, realtime=True, recordings=tmp_path)
