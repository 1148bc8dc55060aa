"""`deltactl init`: what it writes passes the checks it will be held to, and runs."""

from __future__ import annotations

import json
import shlex
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from command_line.recordings.init import _ask as asked_by_hand
from firmware_py.describing.first_job import write_first_job
from firmware_py.describing.questions import QUESTIONS, WIRING, Question, gather, numbers, remarks
from firmware_py.describing.robot_text import robot_text
from firmware_py.program.dry_run import check_job
from firmware_py.robot_file import load_robot
from foundation.errors import ConfigError
from models.robot import KINDS, ServoAxis, load_robot_model
from recording.tables.flat import FlatRecording
from recording.tables.flat_files import write_flat

Deltactl = Callable[..., subprocess.CompletedProcess[str]]
DELTA = {
    "name": "mine", "base_radius_mm": "120", "platform_radius_mm": "40", "upper_arm_mm": "150",
    "forearm_mm": "320", "microsteps_per_rev": "3200", "gear_ratio": "5",
    "sensors": "xyz",
}  # fmt: skip
WIRED = {
    "step_pins": "17 27 22", "direction_pins": "23,24,25", "enable_pin": "5", "alarm_pins": "none",
    "estop_pin": "26", "xshut_pins": "4 20 21", "arm_deg": "-10 90", "joint_speed_radps": "4",
    "joint_acceleration_radps2": "20", "home_deg": "30 30 30", "step_rate_hz": "20000",
    "approach_speed_radps": "0.5",
}  # fmt: skip


def options(answers: dict[str, str]) -> list[str]:
    return [word for key, text in answers.items() for word in (f"--{key.replace('_', '-')}", text)]


def test_from_options_to_a_simulated_job(deltactl: Deltactl, tmp_path: Path) -> None:
    shown = deltactl("init", "mine.yaml", *options(DELTA)).stdout
    assert "next: deltactl check mine-circle.yaml\nthen: deltactl run mine-circle.yaml" in shown
    result = json.loads(deltactl("run", "mine-circle.yaml", "--simulate", "--json").stdout)
    assert result["outcome"] == "done"
    assert load_robot(tmp_path / "mine.yaml").left_open()


def test_interchanged_arms_are_refused_and_leave_no_file(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    arms = {"upper_arm_mm": DELTA["forearm_mm"], "forearm_mm": DELTA["upper_arm_mm"]}
    refused = deltactl("init", "mine.yaml", *options(DELTA | arms), status=2)
    assert "interchanged? Nothing was written" in refused.stderr
    assert not list(tmp_path.iterdir())


def test_what_was_taken_unasked_and_full_steps_are_said() -> None:
    said = {key: text for key, text in DELTA.items() if key != "microsteps_per_rev"}
    answers = gather(QUESTIONS["delta"], said, None)
    assert "--microsteps-per-rev 1600" in remarks(QUESTIONS["delta"], said, answers)[0]
    assert remarks(QUESTIONS["delta"], DELTA, DELTA) == []
    full = DELTA | {"microsteps_per_rev": "200"}
    assert "200 pulses for one turn are full steps" in remarks(QUESTIONS["delta"], full, full)[0]
    for pulses, instead in (("128", "25600"), ("100", "20000"), ("256", "51200")):
        few = DELTA | {"microsteps_per_rev": pulses}
        assert remarks(QUESTIONS["delta"], few, few)[0].endswith(f"write {instead}")
    assert remarks(QUESTIONS["range_sensor"], {"name": "tof"}, {"name": "tof"}) == []


@pytest.mark.parametrize("key", [one.key for one in WIRING])
def test_hardware_is_told_nothing_that_nobody_said(key: str) -> None:
    """Not one of pins, limits and homing has a default."""
    said = {name: value for name, value in WIRED.items() if name != key}
    with pytest.raises(ConfigError, match=f"--{key.replace('_', '-')} is missing"):
        gather(WIRING, said, None)


def test_one_answer_about_hardware_asks_for_all(deltactl: Deltactl) -> None:
    said = deltactl("init", "m.yaml", *options(DELTA), "--estop-pin", "26", status=2).stderr
    assert "--step-pins is missing" in said
    assert "--home-deg is missing" in said


def test_an_answer_to_what_is_not_asked_is_refused(deltactl: Deltactl) -> None:
    words = ("--kind", "range_sensor", "--gear-ratio", "5")
    assert "--gear-ratio: a range_sensor has" in deltactl("init", "m.yaml", *words, status=2).stderr


def test_with_its_wiring_nothing_is_left_open(deltactl: Deltactl, tmp_path: Path) -> None:
    deltactl("init", "mine.yaml", "--wiring", *options(DELTA | WIRED))
    robot = load_robot(tmp_path / "mine.yaml")
    assert robot.left_open() == []
    assert robot.steps.alarm_pins is None
    assert robot.limits.arm_deg == (-10.0, 90.0)


def test_without_sensors_nothing_is_asked_of_their_pins(deltactl: Deltactl, tmp_path: Path) -> None:
    """Nor are pins kept for them: the drives may have those that sensors usually take."""
    said = {key: text for key, text in (DELTA | WIRED).items() if key != "xshut_pins"}
    pins = {"sensors": "none", "step_pins": "4 20 21", "direction_pins": "2 3 24"}
    deltactl("init", "mine.yaml", "--wiring", *options(said | pins))
    assert "xshut" not in (tmp_path / "mine.yaml").read_text()
    assert load_robot(tmp_path / "mine.yaml").left_open() == []
    assert "XSHUT" not in deltactl("install", "--robot", "mine.yaml").stdout


def _weight(deltactl: Deltactl, file: str, *said: str) -> ServoAxis:
    words = ("--kind", "servo_axis", "--recorded", "effort", "--inertia", "1", *said)
    deltactl("init", file, *words)
    robot = load_robot_model(Path(file))
    assert isinstance(robot, ServoAxis)
    return robot


def test_a_weight_on_an_axis_is_asked_for_where_there_is_an_effort(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    path = str(tmp_path / "axis.yaml")
    hung = _weight(deltactl, path, "--hanging-nm", "12", "--hanging-deg", "90").gravity
    assert hung is not None
    assert (hung.torque_nm, hung.force_n) == (12.0, 0.0)
    assert hung.zero_rad == pytest.approx(np.pi / 2)
    path = str(tmp_path / "slide.yaml")
    slope = _weight(deltactl, path, "--motion", "linear", "--slope-n", "-30").gravity
    assert slope is not None
    assert (slope.torque_nm, slope.force_n) == (0.0, -30.0)
    assert _weight(deltactl, str(tmp_path / "level.yaml")).gravity is None
    says = (tmp_path / "level.yaml").read_text(encoding="utf-8")
    assert "only where a weight hangs on the axis: N m that hold it level; the angle in rad" in says


def test_only_the_weight_that_may_be_is_asked_for() -> None:
    """Of a joint also where only commands are recorded: a weight makes it yield."""
    for motion, recorded, expected in (
        ("rotary", "both", ["hanging_nm"]),
        ("linear", "effort", ["slope_n"]),
        ("rotary", "command", ["hanging_nm"]),
        ("linear", "command", []),
    ):
        asked: list[str] = []

        def answer(question: Question, asked: list[str] = asked) -> str:
            asked.append(question.key)
            return question.default or "1"

        gather(QUESTIONS["servo_axis"], {"motion": motion, "recorded": recorded}, answer)
        weights = [key for key in asked if key in ("hanging_nm", "hanging_deg", "slope_n")]
        assert weights == expected


def test_a_weight_that_was_given_is_written(deltactl: Deltactl, tmp_path: Path) -> None:
    """Beside commands alone it was left out without a word."""
    deltactl("init", "a.yaml", "--kind", "servo_axis", "--motion", "rotary", "--hanging-nm", "1.72")
    assert "\ngravity: {torque_nm: 1.72, zero_rad: 0" in (tmp_path / "a.yaml").read_text()


def test_all_that_is_missing_is_said_at_once(deltactl: Deltactl) -> None:
    refused = deltactl("init", "mine.yaml", "--gear-ratio", "5", status=2)
    said = refused.stderr.splitlines()
    assert [line.split()[1] for line in said] == [
        "--base-radius-mm", "--platform-radius-mm", "--upper-arm-mm", "--forearm-mm",
    ]  # fmt: skip


def test_a_refused_answer_leaves_no_file(deltactl: Deltactl, tmp_path: Path) -> None:
    wrong = DELTA | {"upper_arm_mm": "150000", "gear_ratio": "-1"}
    refused = deltactl("init", "mine.yaml", *options(wrong), status=2)
    assert "--upper-arm-mm '150000': must not be above 9999" in refused.stderr
    assert "--gear-ratio '-1': must not be below 1" in refused.stderr
    wrong = DELTA | {"microsteps_per_rev": "1600.5"}
    refused = deltactl("init", "mine.yaml", *options(wrong), status=2)
    assert "drive.microsteps_per_rev" in refused.stderr
    assert not list(tmp_path.glob("*.yaml"))


def test_a_file_is_written_over_only_with_force(deltactl: Deltactl, tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text("precious")
    refused = deltactl("init", "mine.yaml", "--kind", "range_sensor", status=2)
    assert "--force" in refused.stderr
    assert (tmp_path / "mine.yaml").read_text() == "precious"
    deltactl("init", "mine.yaml", "--kind", "range_sensor", "--force")
    assert load_robot_model(tmp_path / "mine.yaml").kind == "range_sensor"


@pytest.mark.parametrize("kind", sorted(set(KINDS) - {"delta"}))
def test_every_kind_with_what_enter_means(tmp_path: Path, kind: str) -> None:
    answers = {one.key: one.default or "12" for one in QUESTIONS[kind]}
    (tmp_path / "one.yaml").write_text(robot_text(kind, answers, wired=False))
    assert load_robot_model(tmp_path / "one.yaml").kind == kind


def test_a_torque_per_ampere_is_kept_where_the_inertia_is_not_known(tmp_path: Path) -> None:
    answers = {one.key: one.default or "joint" for one in QUESTIONS["servo_axis"]}
    answers["effort_gain"] = "0.12"
    path = tmp_path / "joint.yaml"
    path.write_text(robot_text("servo_axis", answers, wired=False))
    axis = load_robot_model(path)
    assert isinstance(axis, ServoAxis)
    assert (axis.inertia, axis.effort_gain) == (None, 0.12)


def test_the_gear_is_measured_from_steps_and_angle(deltactl: Deltactl, tmp_path: Path) -> None:
    t_s = 0.01 * np.arange(500)
    steps = np.round(20_000 * np.sin(t_s))
    rad = steps * 2 * np.pi / (3200 * 50.0) + 0.2
    write_flat(FlatRecording(t_s, {"steps_1": steps, "theta_1": rad}), tmp_path / "run.csv")
    deltactl(
        "init", "table.yaml", "--kind", "stepper_axis", "--measure", "run.csv",
        "--microsteps-per-rev", "3200",
    )  # fmt: skip
    robot = load_robot_model(tmp_path / "table.yaml")
    assert robot.drive.gear_ratio == pytest.approx(50.0, rel=1e-4)


def test_questions_are_asked_where_somebody_sits() -> None:
    asked: list[str] = []

    def ask(question) -> str:
        asked.append(question.key)
        return question.default or "1"

    gather(QUESTIONS["delta"] + WIRING, {"name": "x"}, ask)
    assert "name" not in asked
    assert {"forearm_mm", "step_pins"} <= set(asked)
    with pytest.raises(ConfigError) as error:
        gather(WIRING, {}, None)
    assert len(error.value.args) == len([one for one in WIRING if one.default is None])


def test_an_answer_that_cannot_be_taken_is_asked_for_again(monkeypatch) -> None:
    typed = iter(["rotary", "95.1"])
    monkeypatch.setattr("command_line.recordings.init.typer.prompt", lambda *_, **__: next(typed))
    (inertia,) = (one for one in QUESTIONS["servo_axis"] if one.key == "inertia")
    assert asked_by_hand(inertia) == "95.1"
    kinds = {one.key: one for one in (*QUESTIONS["servo_axis"], *WIRING)}
    assert kinds["motion"].wrong("turning") == "'turning': must be rotary or linear"
    assert not kinds["estop_pin"].wrong("none")
    assert not kinds["step_pins"].wrong("17, 27, 22")
    for one in (*QUESTIONS["delta"], *QUESTIONS["servo_axis"]):
        assert one.default is None or not one.wrong(one.default)


def test_a_decimal_comma_is_one_and_a_doubtful_answer_is_asked_for_again() -> None:
    asked = {one.key: one for one in (*QUESTIONS["delta"], *WIRING)}
    assert not asked["upper_arm_mm"].wrong("314,2")
    assert numbers({"upper_arm_mm": "314,2"}, "upper_arm_mm") == (314.2,)
    assert numbers({"gear_ratio": "5:2"}, "gear_ratio") == (2.5,)
    assert numbers({"arm_deg": "-20, 110"}, "arm_deg", 2) == (-20.0, 110.0)
    for key, answer, wrong in (
        ("upper_arm_mm", "1,200", "'1,200': is it 1200 or 1.200? Write it without a comma"),
        ("upper_arm_mm", "150 320", "'150 320': must be a number"),
        ("upper_arm_mm", "-150", "'-150': must not be below 1"),
        ("upper_arm_mm", "0.15", "'0.15': must not be below 1 mm; is it in metres? Then write 150"),
        ("gear_ratio", "5:0", "'5:0': must be a number"),
        (
            "gear_ratio",
            "0.25",
            "'0.25': did you mean 4? The motor turns 4 times for one turn of the arm",
        ),
        (
            "microsteps_per_rev",
            "16",
            "'16': 16 microsteps a full step? Of a motor with 200 steps a turn that is"
            " --microsteps-per-rev 3200. Of a motor with fewer, write both: a 28BYJ-48 has 32, in"
            " half steps --microsteps-per-rev 32x2 --gear-ratio 63.68",
        ),
        ("step_pins", "17 27", "'17 27': must be 3 numbers, with spaces between"),
        ("arm_deg", "-20 to 110", "'-20 to 110': must be 2 numbers"),
    ):
        assert asked[key].wrong(answer) == wrong


@pytest.mark.parametrize(
    ("said", "pulses"), [("32x2", 64), ("32 x 1", 32), ("200*16", 3200), ("1600", 1600)]
)
def test_a_motor_may_have_few_full_steps_where_that_is_said(
    deltactl: Deltactl, tmp_path: Path, said: str, pulses: int
) -> None:
    """A geared tin-can motor has 32; its file was taken, but not written."""
    asked = DELTA | {"microsteps_per_rev": said, "gear_ratio": "63.68"}
    shown = deltactl("init", "m.yaml", *options(asked)).stdout
    assert load_robot(tmp_path / "m.yaml").drive.microsteps_per_rev == pulses
    assert "look here" not in shown
    read = f"--microsteps-per-rev: {said} is read as {pulses} pulses for one turn"
    assert (read in shown) is (said != "1600")
    refused = deltactl("init", "n.yaml", *options(asked | {"microsteps_per_rev": "0x2"}), status=2)
    assert "0x2" in refused.stderr


@pytest.mark.parametrize("said", ["4:1", "1:4", "1 : 4"])
def test_a_reduction_is_read_either_way_round(
    deltactl: Deltactl, tmp_path: Path, said: str
) -> None:
    shown = deltactl("init", "m.yaml", *options(DELTA | {"gear_ratio": said})).stdout
    assert f"{said} is read as 4: the motor turns 4 times for one turn of the arm" in shown
    assert load_robot(tmp_path / "m.yaml").drive.gear_ratio == 4.0


def test_an_arm_geared_up_is_refused_in_its_file_too(deltactl: Deltactl, tmp_path: Path) -> None:
    deltactl("init", "m.yaml", *options(DELTA))
    file = tmp_path / "m.yaml"
    file.write_text(file.read_text().replace("gear_ratio: 5", "gear_ratio: 0.25"))
    refused = deltactl("check", "m-circle.yaml", status=2).stderr
    assert "drive.gear_ratio: 0.25: did you mean 4?" in refused


def test_all_options_that_cannot_be_taken_are_told_with_those_that_are_missing() -> None:
    with pytest.raises(ConfigError) as error:
        gather(
            QUESTIONS["delta"], {"name": "x", "base_radius_mm": "INCH", "forearm_mm": "-1"}, None
        )
    first, second, *missing = error.value.args
    assert first == "--base-radius-mm 'INCH': must be a number"
    assert second == "--forearm-mm '-1': must not be below 1"
    assert all("is missing" in one for one in missing)


@given(
    base=st.floats(20, 400), platform=st.floats(10, 200),
    upper=st.floats(30, 500), longer=st.floats(1.3, 3.0), gear=st.floats(1, 50),
)  # fmt: skip
@settings(
    max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
def test_the_first_job_of_any_delta_may_run(
    tmp_path: Path, base: float, platform: float, upper: float, longer: float, gear: float
) -> None:
    answers = DELTA | {
        "base_radius_mm": f"{base:.1f}", "platform_radius_mm": f"{platform:.1f}",
        "upper_arm_mm": f"{upper:.1f}", "forearm_mm": f"{longer * upper:.1f}",
        "gear_ratio": f"{gear:.2f}",
    }  # fmt: skip
    file, job = tmp_path / "any.yaml", tmp_path / "any-circle.yaml"
    file.write_text(robot_text("delta", answers, wired=False))
    if write_first_job(load_robot(file), file, job) is None:
        assert not job.exists()
    else:
        assert check_job(job).duration_s > 0.0


def test_a_delta_without_sensors_says_none_and_its_first_job_runs(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    done = deltactl(
        "init", "bare.yaml", "--base-radius-mm", "120", "--platform-radius-mm", "40",
        "--upper-arm-mm", "150", "--forearm-mm", "320", "--gear-ratio", "5", "--sensors", "none",
    )  # fmt: skip
    assert load_robot(tmp_path / "bare.yaml").sensors is None
    assert "then: deltactl run bare-circle.yaml\n" in done.stdout
    assert "then type: deltactl home --accept-unseen 80" in done.stdout
    deltactl("run", "bare-circle.yaml", "--simulate")


def test_no_diagnosis_is_promised_where_nothing_is_observed(deltactl: Deltactl) -> None:
    """The command cannot work on this robot's own recordings; what would make it is said."""
    bare = deltactl("init", "bare.yaml", *options(DELTA | {"sensors": "none"})).stdout
    assert "deltactl diagnose" not in bare
    assert "columns theta_1..3" in bare
    seen = deltactl("init", "seen.yaml", *options(DELTA)).stdout
    assert "then: deltactl diagnose RECORDING --robot seen.yaml" in seen


def test_arms_in_cm_are_told_what_to_write_and_leave_no_file(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    lengths = {"base_radius_mm": "95", "platform_radius_mm": "35", "upper_arm_mm": "11"}
    wrong = DELTA | lengths | {"forearm_mm": "26"}
    (line,) = deltactl("init", "cm.yaml", *options(wrong), status=2).stderr.splitlines()
    assert "11 + 26 mm of the arm are less than the 60 mm between" in line
    assert "in cm? Then write 110 and 260. Nothing was written" in line
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("recorded", "asked"),
    [
        ("command", {"zero", "hanging_nm"}),
        ("effort", {"inertia", "effort_gain", "hanging_nm"}),
        ("both", {"zero", "inertia", "effort_gain", "hanging_nm"}),
    ],
)
def test_nothing_is_asked_about_what_is_not_recorded(recorded: str, asked: set[str]) -> None:
    heard: list[str] = []

    def ask(question: Question) -> str:
        heard.append(question.key)
        return recorded if question.key == "recorded" else question.default or "x"

    answers = gather(QUESTIONS["servo_axis"], {}, ask)
    assert set(heard) - {"name", "motion", "recorded"} == asked
    assert (answers["zero"], answers["inertia"]) == ("absolute", "0")


def spreadsheet(path: Path) -> None:
    """What a spreadsheet writes in half of Europe, of a slide that is driven by steps."""
    t_s = 0.05 * np.arange(400)
    command_mm = 100.0 * np.sin(t_s)
    rows = [
        f"{1e3 * t:.1f};{round(80.0 * x)};{1.002 * x:.4f}".replace(".", ",")
        for t, x in zip(t_s, command_mm, strict=True)
    ]
    path.write_text("\n".join(["Zeit [ms];steps;Laser_mm", *rows]), encoding="utf-8")


def test_a_recording_is_measured_as_inspect_reads_it(deltactl: Deltactl, tmp_path: Path) -> None:
    spreadsheet(tmp_path / "log.csv")
    words = ("--kind", "servo_axis", "--motion", "linear", "--measure", "log.csv")
    done = deltactl("init", "slide.yaml", *words)
    read = "--set 't=Zeit[ms]'"
    assert f"next: deltactl diagnose log.csv --robot slide.yaml {read}" in done.stdout
    assert "write 1 divided by the steps per mm that are set" in done.stderr
    next_one = done.stdout.splitlines()[-1].removeprefix("next: deltactl ")
    deltactl(*shlex.split(next_one))
