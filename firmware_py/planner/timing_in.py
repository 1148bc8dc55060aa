"""A path in a given time: the speed at which it takes so long, found by halving."""

from __future__ import annotations

import math
from collections.abc import Callable

from firmware_py.job_timing import FASTEST_MPS, SLOWEST_MPS
from firmware_py.planner.motion import Schedule
from foundation.clock import NS_PER_S
from foundation.errors import LimitExceeded

CLOSE = 1e-4
"""Share of the duration by which the path may take longer or shorter."""
MOST_HALVINGS = 40


def timed_in(
    duration_s: float, at_speed: Callable[[float], Schedule], mean_mps: float = SLOWEST_MPS
) -> Schedule:
    """The schedule that takes `duration_s`, rests included.

    at_speed: the schedule at a platform speed [m/s]. mean_mps: the speed that would take so long
    without ramps, if it is known. Raises LimitExceeded naming the shortest time there is.
    """
    slow = min(max(mean_mps, SLOWEST_MPS), FASTEST_MPS)
    fast = FASTEST_MPS
    schedule = at_speed(fast)
    if _takes_s(schedule) > duration_s * (1.0 + CLOSE):
        least_s = math.ceil(100.0 * _takes_s(schedule)) / 100.0
        raise LimitExceeded(
            f"timing.duration_s {duration_s:g}: this path takes {least_s:g} s at the fastest that"
            f" the limits of speed and acceleration allow; give {least_s:g} or more"
        )
    for _ in range(MOST_HALVINGS):
        if abs(_takes_s(schedule) - duration_s) <= CLOSE * duration_s:
            break
        middle = math.sqrt(slow * fast)
        schedule = at_speed(middle)
        if _takes_s(schedule) > duration_s:
            slow = middle
        else:
            fast = middle
    return schedule


def _takes_s(schedule: Schedule) -> float:
    return schedule.duration_ns / NS_PER_S
