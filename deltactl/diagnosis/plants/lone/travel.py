"""What the course of a command (n,) lets an axis tell: where it went, which way, and back."""

from __future__ import annotations

import numpy as np

from deltactl.diagnosis.observations.readings import BoolArray, FloatArray, IntArray
from deltactl.diagnosis.plants.lone.options import COMMANDED_AXIS, LONE


def direction_of(commanded: FloatArray, fresh: BoolArray, hair: float) -> FloatArray:
    """Way of the last move, (n,): 1 up, -1 down, kept while it rests; 0 until the first move.

    fresh (n,): rows that begin a stretch. hair: how far a command must turn back to have turned.
    """
    found = np.zeros(len(commanded))
    way, furthest = 0.0, 0.0
    for row, (here, begins) in enumerate(zip(commanded.tolist(), fresh.tolist(), strict=True)):
        if begins or row == 0:
            way, furthest = 0.0, here
        moved = here - furthest
        if (way == 0.0 and abs(moved) > hair) or way * moved < -hair:
            way, furthest = (1.0 if moved > 0.0 else -1.0), here
        elif way * moved > 0.0:
            furthest = here
        found[row] = way
    return found


def arrivals(commanded: FloatArray, direction: FloatArray, hair: float) -> FloatArray:
    """Way that each row of a table was come to, (n,); 0 where nobody knows.

    A place that is read twice running was left in between. At an end of the travel it was come
    back to from beyond, as bidirectional tests of positioning do (ISO 230-2); elsewhere from
    either side.
    """
    stays = np.abs(np.diff(commanded, prepend=np.inf)) <= hair
    ahead = np.append(direction[1:], 0.0)
    once = stays & ~np.append(stays[1:], False) & ~np.append(False, stays[:-1])
    found: FloatArray = np.where(
        stays, np.where(once & (ahead == -direction), ahead, 0.0), direction
    )
    return found


def ends_earlier_move(
    t_s: FloatArray, commanded: FloatArray, observed: FloatArray, fresh: BoolArray, hair: float
) -> BoolArray:
    """Rows (n,) at the beginning of a stretch in which the axis ends a move that no row commands.

    The command rests from the first row of the stretch on, and the axis comes in from elsewhere
    within the time that a drive takes. observed (n,): NaN where nothing was read. hair: how far a
    command or a reading differs at least to have moved.
    """
    found = np.zeros(len(commanded), dtype=bool)
    begins = np.flatnonzero(fresh)
    for first, end in zip(begins, np.append(begins[1:], len(commanded)), strict=True):
        moves = np.flatnonzero(np.abs(commanded[first:end] - commanded[first]) > hair)
        stood = observed[first : first + moves[0] if len(moves) else end]
        away = np.abs(stood - np.nanmedian(stood)) if np.isfinite(stood).any() else stood
        least = COMMANDED_AXIS.settles_within * float(np.ptp(commanded))
        if not len(away) or not away[0] > max(least, COMMANDED_AXIS.coarsest_steps * hair):
            continue
        there = np.flatnonzero(away < COMMANDED_AXIS.settles_within * away[0])
        if len(there) and t_s[first + there[0]] - t_s[first] < LONE.longest_lag_s:
            found[first : first + there[0]] = True
    return found


def turns(direction: FloatArray, fresh: BoolArray) -> bool:
    """Whether a command turns back within any stretch: only there does play or friction show."""
    known = np.flatnonzero(direction)
    stretch = np.cumsum(fresh)[known]
    back = direction[known][1:] * direction[known][:-1] < 0.0
    return bool(np.any(back & (stretch[1:] == stretch[:-1])))


def rests_under_loads(stays: IntArray, load: FloatArray) -> int:
    """How many rests there are, each counted once for every load on it.

    stays (m,): number of the rest a row lies in, -1 in motion. load (m,): known load on the axis.
    """
    another = COMMANDED_AXIS.another_load * float(np.ptp(load))
    count, rest, stood_under = 0, -1, 0.0
    for stay, pull in zip(stays.tolist(), load.tolist(), strict=True):
        if stay >= 0 and (stay != rest or abs(pull - stood_under) > another):
            count, rest, stood_under = count + 1, stay, pull
    return count
