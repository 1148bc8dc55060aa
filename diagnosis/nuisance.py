"""What is always fitted and never a finding."""

from __future__ import annotations

from dataclasses import dataclass

from diagnosis.candidate import Term


@dataclass(frozen=True, slots=True, eq=False)
class Nuisance:
    """A term that is always fitted and never a finding, held near `term.at` by a prior.

    spread: standard deviation of each moved coordinate.
    """

    term: Term
    spread: tuple[float, ...]
