"""A delay of which only every twentieth moment was recorded, against one made moment by moment."""

from __future__ import annotations

import numpy as np
import pytest

from deltactl.diagnosis.api import diagnose_recordings
from deltactl.models.robot import ServoAxis
from deltactl.recording.tables.flat import FlatRecording, from_columns

AXIS = ServoAxis(kind="servo_axis", name="joint", motion="rotary")
TIME_S, NOISE_RAD, STEP_S = 0.045, 1e-4, 0.0005


def recorded(
    dead_s: float, every: int, begins_s: float = 0.0, ends_s: float = 40.0
) -> FlatRecording:
    """A smooth motion, late by a dead time and a first-order lag, each `every` steps of 0.5 ms."""
    t_s = np.arange(-3.0, ends_s, STEP_S)
    told = 0.2 * np.sin(2.0 * np.pi * 0.7 * t_s) + 0.1 * np.sin(2.0 * np.pi * 1.3 * t_s + 1.0)
    late = np.interp(t_s - dead_s, t_s, told)
    seen = np.empty_like(late)
    at = late[0]
    part = 1.0 - np.exp(-STEP_S / TIME_S)
    for k, aim in enumerate(0.5 * (late + np.roll(late, 1))):  # the middle of each step
        at += (aim - at) * part if k else 0.0
        seen[k] = at
    rows = np.flatnonzero(t_s >= begins_s)[::every]
    noise = NOISE_RAD * np.random.default_rng(3).standard_normal(len(rows))
    columns = {"t": t_s[rows], "command": told[rows], "position": seen[rows] + noise}
    return from_columns(columns, "a.csv")


@pytest.mark.study
@pytest.mark.parametrize("dead_s", [0.04, 0.08])
def test_intervals_hold_though_the_command_bends_between_the_rows(dead_s: float) -> None:
    (late,) = diagnose_recordings(AXIS, [recorded(dead_s, every=92)]).findings
    assert late.effect == "following_lag"
    for name, truth_s in (("time", TIME_S), ("dead_time", dead_s)):
        ((_, low_s, high_s),) = late.parameters[name].components
        assert low_s < truth_s < high_s, name
    total_s = late.parameters["total"].components[0][0]
    assert total_s == pytest.approx(TIME_S + dead_s, abs=2e-3)


@pytest.mark.study
def test_rows_that_are_near_each_other_widen_next_to_nothing() -> None:
    (late,) = diagnose_recordings(AXIS, [recorded(0.06, every=4, ends_s=8.0)]).findings
    ((value_s, low_s, high_s),) = late.parameters["time"].components
    assert value_s == pytest.approx(TIME_S, abs=1e-3)
    assert high_s - low_s < 2e-3


@pytest.mark.study
def test_how_a_recording_begins_within_a_motion_is_no_part_of_its_delay() -> None:
    """A chain that begins at the command, or stands there, would have it catch up at first."""
    (late,) = diagnose_recordings(AXIS, [recorded(0.06, every=20, ends_s=3.0)]).findings
    assert late.parameters["time"].components[0][0] == pytest.approx(TIME_S, abs=2e-3)
    assert late.parameters["dead_time"].components[0][0] == pytest.approx(0.06, abs=2e-3)
