"""A late drive is named with its time, a saturated one with its limit; positions that a log lost
are no error of the model.
"""

from __future__ import annotations

import numpy as np
import pytest

from deltactl.diagnosis.api import diagnose_recordings
from deltactl.models.robot import AxisGravity, EffectEntry, ServoAxis
from deltactl.recording.tables.flat import FlatRecording, from_columns

pytest.importorskip("scipy", reason="the diagnosis needs the extra 'diagnosis'")

SLIDE = ServoAxis(kind="servo_axis", name="slide", motion="linear", inertia=2.0)
PERIOD_S = 0.005


def pushed(late_s: float = 0.0, lost: float = 0.0, slow_s: float = 0.0) -> FlatRecording:
    """A slide that follows its effort late, and of whose positions some are lost.

    late_s, slow_s: dead time and time constant.
    """
    rng = np.random.default_rng(3)
    t_s = np.arange(0.0, 10.0, PERIOD_S)
    swings = ((0.1, 3.0, 0.0), (0.03, 11.0, 1.0), (0.01, 23.0, 2.0))

    def effort_n(at_s: np.ndarray) -> np.ndarray:
        turned = [rate * at_s + phase for _, rate, phase in swings]
        pulls = (
            -2.0 * size * rate**2 * (np.sin(at) + slow_s * rate * np.cos(at))
            for (size, rate, _), at in zip(swings, turned, strict=True)
        )
        return np.asarray(sum(pulls))

    position = np.asarray(sum(size * np.sin(rate * t_s + phase) for size, rate, phase in swings))
    position[rng.random(len(t_s)) < lost] = np.nan
    effort = effort_n(t_s + late_s) + rng.normal(0.0, 0.05, len(t_s))
    return from_columns({"t": t_s, "position": position, "effort": effort}, "pushed")


@pytest.mark.study
def test_a_drive_some_periods_late_is_named_with_its_time() -> None:
    answer = diagnose_recordings(SLIDE, [pushed(late_s=2.0 * PERIOD_S)])
    assert [one.effect for one in answer.findings] == ["following_lag"]
    late = answer.findings[0].parameters["dead_time"]
    assert late.value == pytest.approx(2.0 * PERIOD_S, abs=0.2 * PERIOD_S)
    assert answer.fit.holdout_rms_after_m < 0.2 * answer.fit.holdout_rms_before_m


@pytest.mark.study
def test_a_drive_of_first_order_has_a_time_constant_and_no_other_mass() -> None:
    answer = diagnose_recordings(SLIDE, [pushed(slow_s=0.03)])
    assert [one.effect for one in answer.findings] == ["following_lag"]
    sizes = answer.findings[0].parameters
    assert sizes["time"].value == pytest.approx(0.03, abs=0.003)
    assert sizes["dead_time"].value < 0.003


def test_an_effort_that_only_holds_a_weight_says_nothing_of_a_lag() -> None:
    rng = np.random.default_rng(4)
    t_s = np.arange(0.0, 30.0, 0.02)
    held = SLIDE.model_copy(update={"gravity": AxisGravity(force_n=20.0)})
    position = 0.2 * np.sin(0.3 * t_s) + rng.normal(0.0, 1e-6, len(t_s))
    effort = 20.0 - 0.036 * np.sin(0.3 * t_s) + rng.normal(0.0, 0.2, len(t_s))
    rows = from_columns({"t": t_s, "position": position, "effort": effort}, "held")
    assert diagnose_recordings(held, [rows]).findings == []


@pytest.mark.study
def test_less_than_half_a_period_is_no_finding() -> None:
    assert diagnose_recordings(SLIDE, [pushed(late_s=0.3 * PERIOD_S)]).findings == []


@pytest.mark.study
def test_positions_that_were_lost_are_no_error_of_the_model() -> None:
    whole, holed = pushed(), pushed(lost=0.01)
    answers = [diagnose_recordings(SLIDE, [one]) for one in (whole, holed)]
    assert [answer.verdict for answer in answers] == ["nothing_missing"] * 2
    left = [answer.fit.rms_after_m for answer in answers]
    assert left[1] == pytest.approx(left[0], rel=0.2)


def saturated(limit_n: float) -> FlatRecording:
    """A slide whose drive is asked for up to 5 N."""
    rng = np.random.default_rng(5)
    fine_s = np.arange(0.0, 20.0, 0.001)
    asked = 3.5 * np.sin(4.0 * fine_s) + 1.5 * np.sin(7.0 * fine_s + 1.0)
    speed = np.cumsum(np.clip(asked, -limit_n, limit_n)) * 0.001 / 2.0
    position = np.cumsum(speed - speed.mean()) * 0.001
    rows = slice(None, None, 10)
    effort = asked[rows] + rng.normal(0.0, 0.01, len(fine_s[rows]))
    return from_columns({"t": fine_s[rows], "position": position[rows], "effort": effort}, "asked")


@pytest.mark.study
def test_a_saturated_drive_is_named_with_its_limit_and_corrected() -> None:
    answer = diagnose_recordings(SLIDE, [saturated(3.5)])
    assert [one.effect for one in answer.findings] == ["effort_limit"]
    limit = answer.findings[0].parameters["limit"]
    assert limit.value == pytest.approx(3.5, rel=0.03)
    assert answer.fit.holdout_rms_after_m < 0.3 * answer.fit.holdout_rms_before_m
    entry = EffectEntry(effect="effort_limit", component="axis", parameters={"limit": limit.value})
    corrected = SLIDE.model_copy(update={"effects": (entry,)})
    assert diagnose_recordings(corrected, [saturated(3.5)]).findings == []


def test_a_drive_that_gives_what_is_asked_has_no_limit() -> None:
    assert diagnose_recordings(SLIDE, [saturated(6.0)]).findings == []
