"""A recording is held against its robot in one place, `admission.admit`, and nowhere else."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from deltactl.diagnosis.admission.admit import admit
from deltactl.diagnosis.admission.refusal import Kind
from deltactl.diagnosis.api import diagnose_recordings
from deltactl.foundation.errors import RefusedRecording
from deltactl.models.robot import Drive, RangeSensor, RobotModel, ServoAxis, StepperAxis
from deltactl.recording.tables.flat import FlatRecording, from_columns

ROOT = Path(__file__).parents[2]
JUDGING = ("diagnosis", "cli/recordings", "web", "fleet", "repair", "interface")
"""What reads recordings for a diagnosis, or hands them on to it."""
DOOR = Path("deltactl", "diagnosis", "admission")
REFUSALS = {"RecordingError", "RefusedRecording", "refuse"}
PLANTS = {
    *("DeltaModel", "CommandedAxis", "ForcedAxis", "RangeSensorPlant", "ServoDelta"),
    "ChainPlant",
}
NO_ROBOT_YET = {
    "deltactl/web/behind/own_recordings.py",  # an upload that does not come, or of no recording
}
"""Files that say of a recording what no robot file has to do with. It may only shrink."""

FOLLOWS = ServoAxis(kind="servo_axis", name="follows", motion="rotary")
FORCED = ServoAxis(kind="servo_axis", name="forced", motion="rotary", inertia=1.0)
STEPS = StepperAxis(
    kind="stepper_axis", name="s", drive=Drive(microsteps_per_rev=1600, gear_ratio=1)
)
RANGES = RangeSensor(kind="range_sensor", name="ranges")
T_S = np.arange(400) / 50.0
WAVE = np.sin(T_S)
LATE = np.sin(T_S - 0.06) + 1e-3 * np.random.default_rng(0).standard_normal(len(T_S))
HALF_A_STEP = np.where(np.arange(len(T_S)) == 7, 0.5, np.rint(1e3 * WAVE))


def _called(names: set[str], files: Iterator[Path]) -> set[str]:
    """Files in which one of these names is called."""
    return {
        str(file.relative_to(ROOT))
        for file in files
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and getattr(node.func, "id", None) in names
    }


def _outside_of_the_door() -> Iterator[Path]:
    for place in JUDGING:
        top = ROOT / "deltactl" / place
        for file in sorted(top.rglob("*.py")) if top.is_dir() else [top]:
            if not file.relative_to(ROOT).is_relative_to(DOOR):
                yield file


def test_only_the_door_refuses_a_recording() -> None:
    assert _called(REFUSALS, _outside_of_the_door()) == NO_ROBOT_YET
    using = [file for file in _outside_of_the_door() if "admission.refusal" in file.read_text()]
    assert using == []


def test_only_the_door_takes_a_recording_for_a_machine() -> None:
    """But for a run that is proposed, and the same recording behind a narrower filter."""
    assert _called(PLANTS, _outside_of_the_door()) == {
        "deltactl/diagnosis/experiment/exciting_motion.py",
        "deltactl/diagnosis/plants/chain/plant.py",
        "deltactl/diagnosis/plants/delta/next_runs.py",
        "deltactl/diagnosis/plants/lone/forced_axis.py",
    }


def test_every_diagnosis_goes_through_it_once() -> None:
    assert _called({"admit"}, _outside_of_the_door()) == {"deltactl/diagnosis/api.py"}


def _table(source: str = "x.csv", **columns: np.ndarray) -> FlatRecording:
    return from_columns({"t": T_S, **columns}, source)


@pytest.mark.parametrize(
    ("robot", "recording", "kind", "column"),
    [
        (FOLLOWS, _table(position=LATE), Kind.COLUMNS, "command"),
        (FOLLOWS, _table(command=WAVE, position=0.0 * WAVE), Kind.STILL, "position"),
        (FOLLOWS, _table(command=1e3 * WAVE, position=LATE), Kind.UNITS, "position"),
        (FOLLOWS, _table(command=WAVE, position=-LATE), Kind.SIGN, "position"),
        (FORCED, _table(position=WAVE, effort=1e3 * WAVE), Kind.UNITS, "effort"),
        (FORCED, _table(position=WAVE, effort=0.0 * WAVE), Kind.STILL, "effort"),
        (STEPS, _table(steps_1=HALF_A_STEP, theta_1=LATE), Kind.UNITS, "steps_1"),
        (RANGES, _table(range=LATE), Kind.COLUMNS, "distance"),
    ],
)
def test_a_refusal_names_kind_and_column(
    robot: RobotModel, recording: FlatRecording, kind: Kind, column: str
) -> None:
    (refusal,) = admit(robot, [recording]).refusals
    assert (refusal.kind, refusal.column, refusal.source) == (kind, column, "x.csv")
    with pytest.raises(RefusedRecording) as caught:
        diagnose_recordings(robot, [recording])
    assert str(caught.value) == refusal.says
    assert refusal.remedy in refusal.says


def test_a_refusal_names_the_first_wrong_row() -> None:
    (refusal,) = admit(STEPS, [_table(steps_1=HALF_A_STEP, theta_1=LATE)]).refusals
    assert (refusal.row, refusal.t_s) == (7, pytest.approx(7 / 50.0))


def test_every_recording_gets_a_refusal_of_its_own() -> None:
    good = _table("good.csv", steps_1=np.rint(1e3 * WAVE), theta_1=LATE)
    bad = [_table(f"{n}.csv", steps_1=HALF_A_STEP, theta_1=LATE) for n in range(2)]
    refusals = admit(STEPS, [good, *bad]).refusals
    assert [refusal.source for refusal in refusals] == ["0.csv", "1.csv"]


def test_a_held_out_recording_that_says_nothing_is_left_out_with_its_reason() -> None:
    good = _table("good.csv", command=WAVE, position=LATE)
    still = _table("still.csv", command=WAVE, position=0.0 * WAVE)
    (why,) = admit(FOLLOWS, [good], [still]).passed().left_out
    assert (why.kind, why.column, why.source) == (Kind.STILL, "position", "still.csv")


@pytest.mark.study
def test_a_held_out_recording_is_judged_by_what_the_others_are_judged_by() -> None:
    """One without an effort says nothing about an axis that is diagnosed by its effort."""
    effort = -WAVE + 0.1 * np.sign(np.cos(T_S)) + 1e-3 * np.sin(900.0 * T_S)
    good = _table("good.csv", position=WAVE, effort=effort)
    without = _table("without.csv", command=WAVE, position=LATE)
    answer = diagnose_recordings(FORCED, [good], [without])
    assert any("without.csv" in line and "effort" in line for line in answer.says)


def test_what_is_doubtful_is_kept_in_the_answer() -> None:
    turned = _table(command=300.0 * WAVE, position=300.0 * LATE)
    (doubt,) = admit(FOLLOWS, [turned]).doubts
    assert (doubt.column, doubt.source) == ("position", "x.csv")


def test_nothing_given_is_refused() -> None:
    with pytest.raises(RefusedRecording, match="no recording was given"):
        admit(FOLLOWS, []).passed()
