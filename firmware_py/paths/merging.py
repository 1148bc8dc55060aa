"""How many short straight legs are one line, to within a distance."""

from __future__ import annotations

import numpy as np

from deltactl.firmware_py.paths.legs import Legs
from deltactl.firmware_py.paths.path import BoolArray, Int64Array
from deltactl.models.robot import FloatArray

LONGEST_RUN = 1000
"""Legs looked at together: a line of more is as good in two."""
KNOWN = 8
"""Up to so many it is worked out for all legs at once whether they are one line."""


def ends_of_lines(start_m: FloatArray, legs: Legs, within_m: float) -> Int64Array:
    """Numbers of legs that are left, (k,), where runs of short straight ones are made one.

    Points in between are then no further from it than `within_m`; a dwell, another speed, and a
    turn back end a run. So a curve given by many points is not bent at each by their rounding,
    and a corner may reach over more than the last of the points before it.
    """
    if within_m <= 0.0:
        return np.arange(len(legs))
    kept: list[int] = []
    places = np.concatenate([np.asarray(start_m)[None], legs.to_m])
    ends, lines = _plain_runs(legs).tolist(), Lines(places, within_m)
    number = 0
    while number < len(legs):
        run = min(ends[number] - number, LONGEST_RUN)
        number += lines.longest(number, run)
        kept.append(number - 1)
    return np.array(kept)


def _plain_runs(legs: Legs) -> Int64Array:
    """For each leg, (n,), the one behind the last that is straight and as fast, without a rest
    before it."""
    plain = ~(legs.is_arc | legs.spline)
    goes_on = plain[:-1] & plain[1:] & (legs.dwell_s[:-1] == 0.0)
    goes_on &= legs.speed_mps[:-1] == legs.speed_mps[1:]
    behind = np.append(np.flatnonzero(~goes_on) + 1, len(legs))
    return np.repeat(behind, np.diff(behind, prepend=0))


class Lines:
    """Which short legs between points (n + 1, 3) are one line, to within a distance."""

    def __init__(self, points: FloatArray, within_m: float):
        self._points, self._within_m = points, within_m
        self._known = {
            count: _are_lines(points, count, within_m).tolist() for count in range(2, KNOWN + 1)
        }

    def longest(self, first: int, most: int) -> int:
        """How many of at most so many legs, from one on, are one line.

        Every point in between is no further from that line than `within_m`, and every leg goes
        forward along it. At least one; found by doubling, so that a long line costs little.
        """
        good, bad = 1, most + 1
        while good < bad - 1:
            tried = min(2 * good, bad - 1) if bad == most + 1 else (good + bad) // 2
            if self._is_line(first, tried):
                good = tried
            else:
                bad = tried
        return good

    def _is_line(self, first: int, count: int) -> bool:
        if count in self._known:
            return bool(self._known[count][first])
        points = self._points[first : first + count + 1]
        return bool(_are_lines(points, count, self._within_m)[0])


def _are_lines(points: FloatArray, count: int, within_m: float) -> BoolArray:
    """Whether so many legs from each of the points (n + 1, 3) on are one line, (n + 1 - count,)."""
    starts = max(len(points) - count, 0)
    whole = points[count:] - points[:starts]
    length_m = np.linalg.norm(whole, axis=1)
    along = whole / np.where(length_m > 0.0, length_m, 1.0)[:, None]
    found: BoolArray = length_m > 0.0
    if count > KNOWN:  # few starts, and many points
        hops, out = np.diff(points, axis=0), points[1:-1] - points[0]
        away = out - np.outer(out @ along[0], along[0])
        near = np.einsum("ni,ni->n", away, away).max(initial=0.0) <= within_m**2
        return found & bool((hops @ along[0] > 0.0).all() and near)
    before_m = np.zeros(starts)
    for number in range(1, count + 1):
        out = points[number : number + starts] - points[:starts]
        run_m = np.einsum("ni,ni->n", out, along)
        away_m = np.linalg.norm(out - run_m[:, None] * along, axis=1)
        found &= (run_m > before_m) & ((away_m <= within_m) | (number == count))
        before_m = run_m
    return found
