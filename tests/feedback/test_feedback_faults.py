"""Faults while feedback is on: what it corrects, what it leaves alone, and what bounds it."""

from __future__ import annotations

import numpy as np
import pytest

from deltactl.firmware_py.feedback.feedback import farthest_m
from deltactl.firmware_py.feedback.settings import FeedbackSettings
from deltactl.firmware_py.planner.plan import home_counts
from deltactl.models.robot import FloatArray
from tests.feedback.loop import ROBOT, Lie, Loop, planned, rms_m

FAULT_S = 6.0
STEP_M = 2e-4
"""A few microsteps at the platform."""


def recovered_m(t_s: FloatArray, off_m: FloatArray, within_s: float = 5.0) -> float:
    """Farthest from the plan, from so long after a fault on."""
    return float(off_m[t_s > FAULT_S + within_s].max())


def test_with_nothing_wrong_nothing_is_moved() -> None:
    _, off_m = Loop().run()
    assert rms_m(off_m) == 0.0


def test_two_motors_that_lose_steps_at_once_are_both_put_right() -> None:
    loop = Loop(losses=((0, 60, FAULT_S), (2, -80, FAULT_S)))
    t_s, off_m = loop.run()
    assert off_m.max() > 5e-3
    assert recovered_m(t_s, off_m) < 0.5e-3
    np.testing.assert_allclose(loop.feedback.offset, [60, 0, -80], atol=5)


@pytest.mark.parametrize("latency_s", [0.1, 0.2])
def test_readings_that_are_late_neither_move_anything_nor_make_it_ring(latency_s: float) -> None:
    loop = Loop(latency_s=latency_s, losses=((1, 100, FAULT_S),))
    t_s, off_m = loop.run()
    before = off_m[t_s < FAULT_S - 0.2]
    assert before.max() < STEP_M
    assert recovered_m(t_s, off_m) < 0.6e-3
    assert loop.feedback.offset[0] == loop.feedback.offset[2] == 0


def frozen() -> Lie:
    held: list[float] = []

    def says(axis: str, t_s: float, range_m: float) -> float:
        if axis == "y" and t_s > FAULT_S:
            held.append(range_m)
            return held[0]
        return range_m

    return says


def offset(axis: str, t_s: float, range_m: float) -> float:
    return range_m + 0.03 * (axis == "z" and t_s > FAULT_S)


def drift(axis: str, t_s: float, range_m: float) -> float:
    return range_m + 0.002 * max(t_s - FAULT_S, 0.0) * (axis == "x")


@pytest.mark.parametrize(("says", "axis"), [(frozen(), "y"), (offset, "z"), (drift, "x")])
def test_a_sensor_that_lies_is_named_and_nothing_is_moved(says: Lie, axis: str) -> None:
    loop = Loop(says=says)
    _, off_m = loop.run()
    assert loop.feedback.suspect == axis
    assert off_m.max() < STEP_M


def test_a_dead_sensor_moves_nothing() -> None:
    def dead(axis: str, t_s: float, range_m: float) -> float:
        return np.nan if axis == "x" and t_s > FAULT_S else range_m

    loop = Loop(says=dead)
    _, off_m = loop.run()
    assert off_m.max() < STEP_M


def test_whatever_all_sensors_say_the_platform_stays_within_the_stated_distance() -> None:
    def all_lie(axis: str, t_s: float, range_m: float) -> float:
        return range_m + 0.05 * (t_s > FAULT_S)

    settings = FeedbackSettings(most_m=0.004)
    loop = Loop(settings=settings, says=all_lie)
    _, off_m = loop.run()
    path = np.array(home_counts(ROBOT)) + np.cumsum(planned(1).steps, axis=0)
    stated_m = farthest_m(ROBOT, settings, path * ROBOT.drive.rad_per_step)
    assert 0.002 < off_m.max() <= stated_m
    assert stated_m < 0.02
