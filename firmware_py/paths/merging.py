"""How many short straight legs are one line, to within a distance."""

from __future__ import annotations

import numpy as np

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
