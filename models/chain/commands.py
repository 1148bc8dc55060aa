"""What a robot was asked to do over time, and what a perfect instrument would have seen of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from deltactl.models.robot import AnyDrive, FloatArray

BoolArray = np.ndarray[Any, np.dtype[np.bool_]]


@dataclass(frozen=True, slots=True, eq=False)
class Commands:
    """Commanded arm angles over time.

    t_s: (n,), increasing. angles_rad: (n, joints). fresh: (n,) bool, True where a new
    stretch starts (the first sample always is one).
    """

    t_s: FloatArray
    angles_rad: FloatArray
    fresh: BoolArray

    @classmethod
    def of_angles(
        cls, t_s: FloatArray, angles_rad: FloatArray, fresh: BoolArray | None = None
    ) -> Commands:
        """Commands given as arm angles [rad]. Raises ValueError on shapes that do not fit."""
        t_s = np.asarray(t_s, dtype=np.float64)
        angles_rad = np.asarray(angles_rad, dtype=np.float64)
        if t_s.ndim != 1 or angles_rad.ndim != 2 or len(t_s) != len(angles_rad) or not len(t_s):
            raise ValueError(f"times {t_s.shape} and angles {angles_rad.shape} do not belong")
        marks = np.zeros(len(t_s), dtype=bool) if fresh is None else np.array(fresh, dtype=bool)
        marks[0] = True
        return cls(t_s, angles_rad, marks)

    @classmethod
    def of_counts(
        cls, t_s: FloatArray, counts: FloatArray, drive: AnyDrive, fresh: BoolArray | None = None
    ) -> Commands:
        """Commands given as microstep counts, (n, joints)."""
        angles_rad = np.asarray(counts, dtype=np.float64) * drive.rad_per_step
        return cls.of_angles(t_s, angles_rad, fresh)


class Outputs(NamedTuple):
    """Samples of one call."""

    theta: FloatArray
    """True arm angles [rad], shape (n, 3)."""
    position: FloatArray
    """Platform position [m], shape (n, 3); NaN where the linkage cannot be assembled."""
    ranges: FloatArray
    """Readings of the three distance sensors [m], shape (n, 3)."""
    measured: FloatArray
    """What angle encoders on the arms report [rad], shape (n, 3)."""
