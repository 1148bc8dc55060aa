"""Axes and sensors described by `deltactl init`, and what a recording tells of them."""

from __future__ import annotations

import shlex
from pathlib import Path

import numpy as np
import pytest

from deltactl.firmware_py.describing.questions import QUESTIONS
from deltactl.firmware_py.describing.robot_text import robot_text
from deltactl.models.robot import ServoAxis
from deltactl.models.robot_files import load_robot_model
from deltactl.recording.tables.flat import FlatRecording
from deltactl.recording.tables.flat_files import write_flat
from tests.describing.conftest import Deltactl


def _weight(deltactl: Deltactl, file: str, *said: str) -> ServoAxis:
    recorded = () if "--recorded" in said else ("--recorded", "effort", "--inertia", "1")
    deltactl("init", "axis", file, *recorded, *said)
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


def test_a_weight_on_a_rope_may_hang_beside_one_on_an_arm(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    path = str(tmp_path / "drum.yaml")
    rope = _weight(deltactl, path, "--constant-nm", "9.5*9.81*0.01").gravity
    assert rope is not None
    assert (rope.torque_nm, rope.constant_nm) == (0.0, pytest.approx(0.931950))
    both = _weight(
        deltactl, str(tmp_path / "both.yaml"), "--constant-nm", "-2", "--hanging-nm", "3"
    ).gravity
    assert both is not None
    assert (both.torque_nm, both.constant_nm) == (3.0, -2.0)
    path = str(tmp_path / "unweighed.yaml")
    assert _weight(deltactl, path, "--hanging-nm", "0", "--constant-nm", "unknown").gravity is None


def test_a_weight_that_was_given_is_written(deltactl: Deltactl, tmp_path: Path) -> None:
    """Beside commands alone it was left out without a word."""
    deltactl("init", "axis", "a.yaml", "--motion", "rotary", "--hanging-nm", "1.72")
    assert "\ngravity: {torque_nm: 1.72, zero_rad: 0" in (tmp_path / "a.yaml").read_text()


@pytest.mark.parametrize("kind", sorted(QUESTIONS.keys() - {"delta"}))
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
        "init", "axis", "table.yaml", "--drive", "stepper", "--measure", "run.csv",
        "--microsteps-per-rev", "3200",
    )  # fmt: skip
    robot = load_robot_model(tmp_path / "table.yaml")
    assert robot.drive.gear_ratio == pytest.approx(50.0, rel=1e-4)


def spreadsheet(path: Path) -> None:
    """What a spreadsheet writes in half of Europe, of a slide that is driven by steps."""
    t_s = 0.05 * np.arange(400)
    command_mm = 100.0 * np.sin(t_s)
    rows = [
        f"{1e3 * t:.1f};{round(80.0 * x)};{1.002 * x:.4f}".replace(".", ",")
        for t, x in zip(t_s, command_mm, strict=True)
    ]
    path.write_text("\n".join(["Zeit [ms];steps;Laser_mm", *rows]), encoding="utf-8")


@pytest.mark.study
def test_a_recording_is_measured_as_inspect_reads_it(deltactl: Deltactl, tmp_path: Path) -> None:
    spreadsheet(tmp_path / "log.csv")
    words = ("--motion", "linear", "--measure", "log.csv")
    done = deltactl("init", "axis", "slide.yaml", *words)
    read = "--set 't=Zeit[ms]'"
    assert f"next: deltactl diagnose log.csv --robot slide.yaml {read}" in done.stdout
    assert "put for MM_PER_STEP below what one is" in done.stderr
    assert "MM_PER_STEP: mm for one step, as the drive is set" in done.stderr
    next_one = done.stdout.splitlines()[-1].removeprefix("next: deltactl ")
    deltactl(*shlex.split(next_one.replace("MM_PER_STEP", "0.0125")))


def test_nothing_is_measured_in_a_unit_that_its_owner_has_to_say(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    t_s = 0.01 * np.arange(500)
    columns = np.stack([t_s, 1.2 * np.sin(3.0 * t_s), -np.sin(3.0 * t_s)], axis=1)
    np.savetxt(tmp_path / "log.csv", columns, "%.5f", ",", header="time,pos,iq", comments="")
    words = ("init", "axis", "axis.yaml", "--yes", "--measure", "log.csv")
    refused = deltactl(*words, status=2)
    assert "nothing says the unit of pos; it is deg, rad or turn if it turns" in refused.stderr
    assert not (tmp_path / "axis.yaml").exists()
    deltactl(
        *words,
        "--set",
        "unit=rad",
        "--set",
        "t=time",
        "--set",
        "effort=iq",
        "--set",
        "position=pos",
    )


def test_a_product_is_taken_for_the_torque_and_bounds_hold(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    hung = _weight(deltactl, str(tmp_path / "a.yaml"), "--hanging-nm", "1.17*9.81*0.15").gravity
    assert hung is not None
    assert hung.torque_nm == pytest.approx(1.17 * 9.81 * 0.15)
    done = deltactl("init", "axis", "b.yaml", "--inertia", "-1/3", status=2)
    assert "must not be below 0" in done.stderr


@pytest.mark.parametrize(
    ("motion", "option", "key"),
    [("rotary", "--hanging-nm", "torque_nm"), ("linear", "--slope-n", "force_n")],
)
@pytest.mark.parametrize("recorded", [["both", "--inertia", "1"], ["command"]])
def test_an_answer_of_zero_is_written_and_a_default_is_not(
    deltactl: Deltactl, tmp_path: Path, motion: str, option: str, key: str, recorded: list[str]
) -> None:
    """Beside commands alone the zero of a slide was left out, as if nobody knew."""
    words = ["--motion", motion, "--recorded", *recorded]
    free = _weight(deltactl, str(tmp_path / "free.yaml"), *words, option, "0").gravity
    assert free is not None
    assert (free.torque_nm, free.force_n) == (0.0, 0.0)
    assert f"\ngravity: {{{key}: 0}}" in (tmp_path / "free.yaml").read_text()
    assert _weight(deltactl, str(tmp_path / "open.yaml"), *words).gravity is None


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--slope-n", "3"], "--slope-n: is of a servo_axis that slides (--motion linear)"),
        (
            ["--motion", "linear", "--hanging-nm", "3"],
            "--hanging-nm: is of a servo_axis that turns (--motion rotary)",
        ),
    ],
)
def test_a_weight_of_the_other_motion_is_refused(
    deltactl: Deltactl, words: list[str], says: str
) -> None:
    done = deltactl("init", "axis", "a.yaml", *words, status=2)
    assert says in " ".join(done.stderr.split())


def test_who_does_not_know_what_hangs_there_may_say_so(deltactl: Deltactl, tmp_path: Path) -> None:
    path = tmp_path / "arm.yaml"
    deltactl("init", "axis", str(path), "--motion", "rotary",
             "--recorded", "command", "--hanging-nm", "unknown")  # fmt: skip
    assert "# gravity: {torque_nm: 1.5" in path.read_text()
