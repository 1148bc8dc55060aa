"""A motion of several joints that comes back: a Fourier series of each, as a job and as a table."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from deltactl.models.robot import FloatArray

SERIES_S = 20.0
"""Length of one series: the slowest wave has 0.05 Hz, the fastest of five 0.25 Hz."""
REPEATS = 3
"""A minute: what comes back in each is no noise."""
RATE_HZ = 50.0


@dataclass(frozen=True, eq=False)
class Series:
    """middle: (joints,) [rad or m]; sine, cosine: (harmonics, joints) of the positions."""

    middle: FloatArray
    sine: FloatArray
    cosine: FloatArray

    def at(self, t_s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Positions and velocities (n, joints)."""
        w = 2.0 * np.pi / SERIES_S * np.arange(1, len(self.sine) + 1)
        sines, cosines = np.sin(np.outer(t_s, w)), np.cos(np.outer(t_s, w))
        return (
            self.middle + sines @ self.sine + cosines @ self.cosine,
            (cosines * w) @ self.sine - (sines * w) @ self.cosine,
        )

    def table(self) -> FloatArray:
        """Times and positions (n, 1 + joints) of all repeats."""
        t_s = np.arange(0.0, REPEATS * SERIES_S + 0.5 / RATE_HZ, 1.0 / RATE_HZ)
        return np.column_stack([t_s, self.at(t_s)[0]])

    def job(self, robot: str) -> dict[str, Any]:
        """As plain data, for any controller."""
        path = {"shape": "fourier", "period_s": SERIES_S}
        parts = (("middle", self.middle), ("sine", self.sine), ("cosine", self.cosine))
        return {
            "name": "exciting-motion", "robot": robot, "repeats": REPEATS,
            "path": path | {name: np.round(each, 6).tolist() for name, each in parts},
        }  # fmt: skip
