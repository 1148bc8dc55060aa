"""What is always fitted and never a finding."""

from __future__ import annotations

from dataclasses import dataclass

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
    together: float | None = None
    """Standard deviation of the sum of the coordinates, where that is known better."""
