"""A held-out run begins in the play wherever it does: on the other side, or with no reversal."""

from __future__ import annotations

import numpy as np
import pytest

from deltactl.diagnosis.api import diagnose_recordings
from deltactl.models.robot import StepperAxis
from deltactl.recording.tables.flat import FlatRecording, from_columns
from tests.axes.axis_rigs import wander

pytestmark = pytest.mark.study

AXIS = StepperAxis(kind="stepper_axis", name="table")
WIDTH_RAD, NOISE_RAD = 0.004, 1e-4


def behind_play(t_s: np.ndarray, driven: np.ndarray, begins: float) -> FlatRecording:
    """Each reading pushed along by one end of the play or the other, sample by sample."""
    at, seen = driven[0] + begins * WIDTH_RAD / 2.0, []
    for here in driven:
        at = min(max(at, here - WIDTH_RAD / 2.0), here + WIDTH_RAD / 2.0)
        seen.append(at)
    noise = NOISE_RAD * np.random.default_rng(len(t_s)).standard_normal(len(t_s))
    return from_columns({"t": t_s, "command_1": driven, "theta_1": np.array(seen) + noise}, "a.csv")


@pytest.fixture(scope="module")
def recording() -> FlatRecording:
    t_s = np.arange(0.0, 60.0, 0.02)
    return behind_play(t_s, wander(np.random.default_rng(0), t_s, 0.1, 2.0), 1.0)


@pytest.mark.parametrize("begins", [-1.0, 0.0, 1.0])
def test_it_is_foretold_from_whichever_side_of_the_play_it_begins_at(
    recording: FlatRecording, begins: float
) -> None:
    """Here all of it is spent on one side, which the recording did not begin at."""
    t_s = np.arange(0.0, 10.0, 0.02)
    held_out = behind_play(t_s, 0.02 + 0.001 * np.sin(t_s), begins)
    answer = diagnose_recordings(AXIS, [recording], [held_out])
    assert [one.effect for one in answer.findings] == ["gear_backlash"]
    assert answer.fit.holdout == "run"
    assert answer.fit.holdout_rms_after_m == pytest.approx(NOISE_RAD, rel=0.5)


def test_one_without_a_reversal_is_foretold_as_well(recording: FlatRecording) -> None:
    t_s = np.arange(0.0, 10.0, 0.02)
    held_out = behind_play(t_s, 0.01 * t_s, -1.0)
    answer = diagnose_recordings(AXIS, [recording], [held_out])
    assert [one.effect for one in answer.findings] == ["gear_backlash"]
    assert answer.fit.holdout_rms_after_m == pytest.approx(NOISE_RAD, rel=0.5)
