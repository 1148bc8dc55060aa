"""Where the platform was for the last few sets of arms' angles.

Most effects leave the angles as they are, or move them as a simulation just before did.
"""

from __future__ import annotations

from collections import deque
from dataclasses import fields

import numpy as np

from deltactl.models.linkage import Linkage, forward
from deltactl.models.robot import FloatArray

KEPT = 4


class Assembled:
    """Forward kinematics that remembers its last few results."""

    def __init__(self) -> None:
        self._last: deque[tuple[Linkage, FloatArray, FloatArray]] = deque(maxlen=KEPT)

    def position_m(self, linkage: Linkage, angles_rad: FloatArray) -> FloatArray:
        """Platform positions (n, 3), the caller's to change; angles (n, 3), not to change."""
        for place, known in enumerate(self._last):
            if np.array_equal(known[1], angles_rad) and _same(known[0], linkage):
                del self._last[place]
                self._last.append(known)
                return known[2].copy()
        position_m = forward(linkage, angles_rad).position_m
        self._last.append((linkage, angles_rad, position_m.copy()))
        return position_m


def _same(one: Linkage, other: Linkage) -> bool:
    return one is other or all(
        np.array_equal(getattr(one, field.name), getattr(other, field.name))
        for field in fields(Linkage)
    )
