"""What is always fitted and never a finding."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.candidate import Term


@dataclass(frozen=True, slots=True, eq=False)
class Nuisance:
    """A term that is always fitted and never a finding, held near `term.at` by a prior.

    spread: standard deviation of each moved coordinate.
    """

    term: Term
    spread: tuple[float, ...]
    measured: bool = False
    """An effect that the robot file has from an earlier diagnosis."""
    held: bool = False
    """Such an effect, or an error of building that this diagnosis needed beside it."""
    together: float | None = None
    """Standard deviation of the sum of the coordinates, where that is known better."""

    @property
    def precision(self) -> FloatArray:
        """Inverse covariance (k, k) of the moved coordinates."""
        own = np.diag(np.array(self.spread) ** -2.0)
        return own if self.together is None else own + self.together**-2.0

    @property
    def directions(self) -> FloatArray:
        """Coordinates (k, k) whose priors do not depend on one another, each of its `spread`."""
        if self.together is None:
            return np.eye(len(self.spread))
        root: FloatArray = np.linalg.cholesky(np.linalg.inv(self.precision))
        directions: FloatArray = root / np.array(self.spread)
        return directions

    def at_sizes(self, sizes: FloatArray) -> Term:
        """The term at sizes (k,) along `directions`, within its bounds."""
        at = self.term.at.copy()
        at[self.term.candidate.moved] += self.directions @ sizes
        return self.term.moved_to(at)

    def sizes(self, at: FloatArray) -> FloatArray:
        """The other way round, of coordinates."""
        away = (at - self.term.at)[self.term.candidate.moved]
        found: FloatArray = np.linalg.solve(self.directions, away)
        return found
