"""Where a fit is on its way."""

from __future__ import annotations

from dataclasses import dataclass

from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.candidate import Term


@dataclass(frozen=True, slots=True, eq=False)
class Point:
    """Terms, what they predict, and what spline terms leave of the rest."""

    nuisances: tuple[Term, ...]
    terms: tuple[Term, ...]
    predicted: FloatArray
    """Channels (n, channels)."""
    residual: FloatArray
    """Whitened, (m,)."""
    taken: FloatArray
    """What an orthonormal basis of the spline terms has of the residual, (q,)."""
    cost: float
    """Chi-square of the rest."""

    @property
    def everything(self) -> list[Term]:
        """Nuisances, then terms."""
        return [*self.nuisances, *self.terms]
