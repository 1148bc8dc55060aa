"""Logs as people keep them: ten readings a second, a coarse encoder, one settled reading a move."""

from __future__ import annotations

import numpy as np
import pytest

from deltactl.diagnosis.answer.records import Diagnosis
from deltactl.diagnosis.api import diagnose_recordings
from deltactl.diagnosis.plants.lone.commanded_axis import CommandedAxis
from deltactl.models.robot import ServoAxis
from deltactl.recording.tables.flat import FlatRecording, from_columns

SERVO = ServoAxis(kind="servo_axis", name="servo", motion="rotary")
COUNT_RAD = 2.0 * np.pi / 4096


def leaps(late_s: float = 0.3) -> FlatRecording:
    """A hobby servo at 10 Hz: commands leap every 3 s, the horn is there three readings later."""
    rng = np.random.default_rng(4)
    t_s = np.arange(200) / 10.0
    asked = np.array([0.0, 0.15, 0.0, -0.15, 0.0, 0.15, 0.0])
    command = asked[np.minimum((t_s // 3.0).astype(int), 6)]
    fine = np.linspace(-5.0, 20.0, 5001)
    ideal = np.where(fine < 0.0, 0.0, asked[np.clip((fine // 3.0).astype(int), 0, 6)])
    seen = np.interp(t_s - late_s, fine, ideal) + 2e-4 * rng.standard_normal(len(t_s))
    return from_columns(
        {"t": t_s, "command": command, "position": np.round(seen / COUNT_RAD) * COUNT_RAD}, "leaps"
    )


def table() -> FlatRecording:
    """A linear axis measured with a gauge: five times there and back in tenths, each settled.

    Going up it stands 40 um further on than coming back: no play does that.
    """
    rng = np.random.default_rng(5)
    there = np.arange(6) * 0.01
    at = np.concatenate([np.concatenate([there, there[-2:0:-1]]) for _ in range(5)])
    upwards = np.diff(at, prepend=-1.0) > 0.0
    seen = at + np.where(upwards, 20e-6, -20e-6) + 2e-6 * rng.standard_normal(len(at))
    return from_columns({"t": 10.0 * np.arange(len(at)), "command": at, "position": seen}, "table")


@pytest.fixture(scope="module")
def answer() -> Diagnosis:
    return diagnose_recordings(SERVO, [leaps()])


@pytest.mark.study
def test_moves_shorter_than_seven_readings_show_a_late_drive(answer: Diagnosis) -> None:
    """What is left stands out only there, and was taken for single readings that are off."""
    assert "following_lag" in [one.effect for one in answer.findings]
    (late,) = (one for one in answer.findings if one.effect == "following_lag")
    total_s = late.parameters["total"].components[0][0]
    assert 0.2 < total_s < 0.45


@pytest.mark.study
def test_what_is_named_as_a_candidate_is_not_said_to_be_beyond_the_recording(
    answer: Diagnosis,
) -> None:
    untold = {one.effect for one in answer.not_testable}
    assert not untold & {"following_lag", "gear_backlash", "joint_friction"}
    assert not any("one speed" in one.why for one in answer.not_testable)


def test_settled_readings_are_all_at_rest() -> None:
    """Turning points alone had been, and counted four hundred times as much as the others."""
    axis = ServoAxis(kind="servo_axis", name="slide", motion="linear")
    assert not CommandedAxis(axis, [table()]).kinds.any()


def test_what_no_effect_can_do_is_not_called_noise() -> None:
    axis = ServoAxis(kind="servo_axis", name="slide", motion="linear")
    answer = diagnose_recordings(axis, [table()])
    assert answer.verdict != "nothing_missing"
    assert answer.fit.noise_floor_m < 15e-6
