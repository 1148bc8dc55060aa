"""What findings are worth on parts and on runs that they were not fitted to."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from deltactl.diagnosis.answer.records import Fit
from deltactl.diagnosis.api import diagnose_recordings
from deltactl.models.robot import DeltaRobot, EffectEntry
from deltactl.recording.tables.flat import FlatRecording

pytestmark = pytest.mark.study

Record = Callable[..., FlatRecording]
HOME = EffectEntry(effect="home_offset", component="motor1", parameters={"angle": 0.03})
LOST = EffectEntry(
    effect="lost_steps", component="motor2", parameters={"steps": 90.0, "time": 13.0}
)
SECONDS = 24.0


def fit(delta: DeltaRobot, seen: FlatRecording, *held_out: FlatRecording) -> Fit:
    return diagnose_recordings(delta, [seen], held_out).fit


def unlike(recording: FlatRecording, rows: slice, by_m: float) -> FlatRecording:
    """With the z sensor off by so much in these rows."""
    columns = {name: values.copy() for name, values in recording.columns.items()}
    columns["range_z"][rows] += by_m
    return replace(recording, columns=columns)


def followed(recording: FlatRecording) -> FlatRecording:
    """With an error of the z sensor that follows the angle of the second motor."""
    columns = {name: values.copy() for name, values in recording.columns.items()}
    turned = columns["steps_2"] / 3300.0
    columns["range_z"] += 0.01 * np.sin(9.0 * turned) ** 3
    return replace(recording, columns=columns)


def test_parts_that_are_held_out_are_foretold(delta: DeltaRobot, record: Record) -> None:
    """A clock that ran before changes nothing of it."""
    seen = record(HOME, seconds=SECONDS)
    found = fit(delta, replace(seen, t_s=seen.t_s + 1000.0))
    assert found.holdout == "blocks"
    assert found.holdout_rms_before_m == pytest.approx(found.rms_before_m, rel=0.05)
    assert found.holdout_rms_after_m == pytest.approx(found.rms_after_m, rel=0.05)


def test_what_is_wrong_in_one_part_is_not_foretold_by_the_others(
    delta: DeltaRobot, record: Record
) -> None:
    seen = record(seconds=SECONDS)
    found = fit(delta, unlike(seen, slice(4 * len(seen) // 5, None), 0.02))
    assert found.holdout_rms_after_m > 2.0 * found.rms_after_m


def test_events_do_not_come_back_in_another_run(delta: DeltaRobot, record: Record) -> None:
    another = record(seconds=SECONDS, seed=2)
    found = fit(delta, record(LOST, seconds=SECONDS), another)
    assert found.holdout == "run"
    assert found.rms_after_m < 0.6 * found.rms_before_m
    assert found.holdout_rms_after_m == pytest.approx(found.holdout_rms_before_m, rel=0.01)


def test_what_lasts_is_held_against_another_run(delta: DeltaRobot, record: Record) -> None:
    """It makes a run better in which it is as well, and one worse in which it is not."""
    seen = record(HOME, seconds=SECONDS)
    again = fit(delta, seen, record(HOME, seconds=SECONDS, seed=2))
    gone = fit(delta, seen, record(seconds=SECONDS, seed=2))
    assert again.holdout_rms_after_m < 0.7 * again.holdout_rms_before_m
    assert gone.holdout_rms_after_m > 1.2 * gone.holdout_rms_before_m


def test_unknowns_that_follow_something_come_back_in_another_run(
    delta: DeltaRobot, record: Record
) -> None:
    another = followed(record(seconds=SECONDS, seed=2))
    found = fit(delta, followed(record(seconds=SECONDS)), another)
    assert found.holdout_rms_after_m < 0.6 * found.holdout_rms_before_m
    assert found.holdout_rms_after_m == pytest.approx(found.rms_after_m, rel=0.15)


def test_one_reading_that_leaps_does_not_make_another_run_look_bad(
    delta: DeltaRobot, record: Record
) -> None:
    seen, another = record(HOME, seconds=SECONDS), record(HOME, seconds=SECONDS, seed=2)
    plain = fit(delta, seen, another)
    leaps = fit(delta, seen, unlike(another, slice(700, 701), 0.4))
    assert leaps.holdout_rms_after_m == pytest.approx(plain.holdout_rms_after_m, rel=0.01)
