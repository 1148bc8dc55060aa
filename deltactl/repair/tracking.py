"""How well a robot drew: where it truly was against the target that was due."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from deltactl.models.robot import FloatArray
from deltactl.repair.played import Played


@dataclass(frozen=True, eq=False)
class Drawn:
    """Target and truth (k, 3) [m] at the same times (k,) [s]."""

    t_s: FloatArray
    target_m: FloatArray
    true_m: FloatArray

    @property
    def error_m(self) -> FloatArray:
        """Distance from the target, (k,) [m]."""
        distance: FloatArray = np.linalg.norm(self.true_m - self.target_m, axis=1)
        return distance

    @property
    def rms_m(self) -> float:
        """Root of the mean squared distance [m]."""
        return float(np.sqrt(np.mean(self.error_m**2)))

    @property
    def worst_m(self) -> float:
        """Largest distance [m]."""
        return float(self.error_m.max())


def drawn(job: Played, t_s: FloatArray, position_m: FloatArray) -> Drawn:
    """A run's truth, times (n,) and positions (n, 3), at the targets of the job."""
    true_m = np.stack([np.interp(job.target_s, t_s, column) for column in position_m.T], axis=1)
    return Drawn(job.target_s, job.target_m, true_m)
