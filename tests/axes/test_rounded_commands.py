"""Logs in counts of an encoder: the command is rounded as the reading is."""

from __future__ import annotations

import numpy as np
import pytest

from deltactl.diagnosis.api import diagnose_recordings
from deltactl.diagnosis.observations.log_errors import unrounded
from deltactl.models.robot import ServoAxis
from deltactl.recording.tables.flat import FlatRecording, from_columns
from tests.axes.axis_rigs import FloatArray, wander

SERVO = ServoAxis(kind="servo_axis", name="drive", motion="rotary", zero="absolute")
COUNT_RAD = 2.0 * np.pi / 2048


def counted(values: FloatArray) -> FloatArray:
    return COUNT_RAD * np.round(values / COUNT_RAD)


def logged(seed: int, play_counts: float = 0.0, moving: bool = True) -> FlatRecording:
    """Moves with rests or a sine, in whole counts; noise of a fifth of one to a whole one."""
    rng = np.random.default_rng(seed)
    t_s, size = np.arange(2000) / 100.0, COUNT_RAD * rng.uniform(100.0, 2000.0)
    asked = wander(rng, t_s, size, 1.2) if moving else size * np.sin(1.7 * t_s)
    at, places = asked[0], []
    half = 0.5 * play_counts * COUNT_RAD
    for one in asked.tolist():
        at = min(max(at, one - half), one + half)
        places.append(at)
    seen = np.array(places) + rng.uniform(0.2, 1.0) * COUNT_RAD * rng.standard_normal(len(t_s))
    columns = {"t": t_s, "command": counted(asked), "position": counted(seen)}
    return from_columns(columns, "counts")


@pytest.mark.parametrize("moving", [True, False])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_rounding_of_a_command_is_no_fault(seed: int, moving: bool) -> None:
    """Of drawn axes like these two in three had a finding."""
    answer = diagnose_recordings(SERVO, [logged(seed, moving=moving)])
    assert answer.verdict == "nothing_missing"
    assert not answer.findings


def test_play_of_two_counts_is_found() -> None:
    answer = diagnose_recordings(SERVO, [logged(4, play_counts=2.0)])
    ((value, low, high),) = next(iter(answer.findings[0].parameters.values())).components
    assert {"gear_backlash", "joint_friction"} >= {one.effect for one in answer.findings}
    assert low < 2.0 * COUNT_RAD < high
    assert high - low < COUNT_RAD
    assert abs(value / COUNT_RAD - 2.0) < 0.5


def test_a_course_is_restored_within_its_rounding() -> None:
    """Nearer to what was commanded than the counts are, never by more than half of one off them."""
    asked = 300.0 * COUNT_RAD * np.sin(0.017 * np.arange(2000))
    restored = unrounded(counted(asked), COUNT_RAD, np.zeros(2000, dtype=np.intp))
    assert np.std(restored - asked) < 0.6 * np.std(counted(asked) - asked)
    assert np.abs(restored - counted(asked)).max() <= 0.501 * COUNT_RAD


def test_a_leap_stays_a_leap() -> None:
    leaps = COUNT_RAD * np.repeat([0.0, 500.0, -200.0, 0.0], 50)
    restored = unrounded(leaps, COUNT_RAD, np.zeros(len(leaps), dtype=np.intp))
    np.testing.assert_allclose(restored, leaps, atol=1e-12)
