"""How many short straight legs are one line, to within a distance."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from deltactl.models.robot import FloatArray

LONGEST_RUN = 1000
"""Legs looked at together: a line of more is as good in two."""


def longest(points: FloatArray, within_m: float) -> int:
    """How many of the legs between points (n + 1, 3) are one line from the first of them.

    Every point in between is no further from that line than `within_m`, and every leg goes
    forward along it. At least one; found by doubling, so that a long line costs little.
    """
    good, bad = 1, len(points)
    while good < bad - 1:
        tried = min(2 * good, bad - 1) if bad == len(points) else (good + bad) // 2
        if _is_line(points[: tried + 1], within_m):
            good = tried
        else:
            bad = tried
    return good


def pairs_in_line(points: FloatArray, within_m: float) -> NDArray[np.bool_]:
    """Whether each two legs that follow each other between points (n + 1, 3) are one line, (n,).

    What longest would find of the first two; False for the last leg, which has none after it.
    """
    found = np.zeros(max(len(points) - 1, 0), dtype=np.bool_)
    if len(points) < 3:
        return found
    whole, first = points[2:] - points[:-2], points[1:-1] - points[:-2]
    length_m = np.linalg.norm(whole, axis=1)
    along = whole / np.where(length_m > 0.0, length_m, 1.0)[:, None]
    run_m = np.einsum("ni,ni->n", first, along)
    away_m = np.linalg.norm(first - run_m[:, None] * along, axis=1)
    found[:-1] = (run_m > 0.0) & (run_m < length_m) & (away_m <= within_m)
    return found


def _is_line(points: FloatArray, within_m: float) -> bool:
    along = points[-1] - points[0]
    length_m = float(np.linalg.norm(along))
    if not length_m:
        return False
    along = along / length_m
    if (np.diff(points, axis=0) @ along <= 0.0).any():
        return False
    out = points[1:-1] - points[0]
    away = out - np.outer(out @ along, along)
    return bool(np.einsum("ni,ni->n", away, away).max(initial=0.0) <= within_m**2)
