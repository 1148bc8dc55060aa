"""A late drive that is told early: it is where the plan is, within speed and acceleration."""

from __future__ import annotations

import numpy as np
import pytest

from deltactl.firmware_py.compensation.lead import Lead
from deltactl.foundation.clock import NS_PER_S
from deltactl.models.robot import FloatArray

MS_NS = 1_000_000
FASTEST_HZ, ACCELERATION_HZPS = 20_000.0, 50_000.0
AFTER_S = 0.2


def led(
    planned: FloatArray,
    lag_s: float,
    acceleration: float = ACCELERATION_HZPS,
    jump_hz: float = 0.0,
) -> FloatArray:
    """Counts told at every millisecond, when the plan (n,) asks for these."""
    grid = np.arange(len(planned)) * MS_NS
    counts = np.rint(planned).astype(np.int64)
    moves = np.diff(counts, prepend=counts[0])
    due = np.concatenate(
        [t - MS_NS + (np.arange(abs(m)) + 1) * MS_NS // abs(m)
         for t, m in zip(grid.tolist(), moves.tolist(), strict=True) if m]
    )  # fmt: skip
    signs = np.concatenate([np.full(abs(m), np.sign(m)) for m in moves.tolist() if m])
    lead = Lead(0.0, lag_s, round(AFTER_S * NS_PER_S), FASTEST_HZ, acceleration, jump_hz)
    made = lead.steps(due.astype(np.int64), signs.astype(np.int64), int(grid[-1]))
    row = np.searchsorted(made[0], grid, side="right")
    told: FloatArray = np.concatenate([[0], np.cumsum(made[1])])[row].astype(np.float64)
    return told


def followed(told: FloatArray, lag_s: float) -> FloatArray:
    """What a drive of the first order makes of it."""
    share, place, out = 1.0 - np.exp(-1e-3 / lag_s), 0.0, []
    for goal in told.tolist():
        place += share * (goal - place)
        out.append(place)
    return np.array(out)


@pytest.mark.parametrize("lag_s", [0.03, 0.1])
def test_a_drive_that_is_late_is_there_in_time(lag_s: float) -> None:
    t_s = np.arange(4000) * 1e-3
    planned = 500.0 * (1.0 - np.cos(2.0 * t_s))
    there = followed(led(planned, lag_s), lag_s)
    late = round(AFTER_S * 1e3)
    inside = slice(late + 500, 3600)
    off = there[inside] - planned[inside.start - late : inside.stop - late]
    assert np.abs(off).max() < 4.0
    untreated = followed(planned, lag_s)[inside] - planned[inside]
    assert np.abs(untreated).max() > 5.0 * np.abs(off).max()


def test_a_corner_at_full_speed_is_rounded_so_much_that_the_motor_can_follow() -> None:
    t_s, rate_hz, lag_s = np.arange(4000) * 1e-3, 500.0, 0.065
    planned = rate_hz * (1.5 - np.abs(t_s - 2.0)).clip(0.0)
    late = round(AFTER_S * 1e3)
    worst = {}
    for jump_hz in (0.0, 2.0 * rate_hz):
        there = followed(led(planned, lag_s, jump_hz=jump_hz), lag_s)
        worst[jump_hz] = np.abs(there[late:] - planned[:-late])[1500:3000].max()
    assert worst[2.0 * rate_hz] < 0.5 * worst[0.0]


def test_a_sudden_start_is_led_no_harder_than_the_motor_may() -> None:
    t_s = np.arange(1500) * 1e-3
    planned = np.clip(4000.0 * (t_s - 0.4), 0.0, 2000.0)
    rate = {}
    for acceleration in (ACCELERATION_HZPS, np.inf):
        told = led(planned, 0.05, acceleration)
        speed_hz = (told[10:] - told[:-10]) / 0.01
        rate[acceleration] = np.abs(speed_hz[10:] - speed_hz[:-10]).max() / 0.01
        assert np.abs(speed_hz).max() <= FASTEST_HZ
    whole_steps = 2.0 / 0.01**2  # of a count at each end of a window
    assert rate[ACCELERATION_HZPS] <= ACCELERATION_HZPS + whole_steps
    assert rate[np.inf] > 2.0 * ACCELERATION_HZPS


def test_nothing_of_the_way_is_lost() -> None:
    t_s = np.arange(3000) * 1e-3
    planned = np.where(t_s < 1.0, 0.0, np.minimum(3000.0 * (t_s - 1.0), 777.0))
    assert led(planned, 0.08)[-1] == 777.0
