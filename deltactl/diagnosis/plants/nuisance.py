"""What is always fitted and never a finding."""

from __future__ import annotations

from collections.abc import Sequence
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


def given_back(
    centres: Sequence[Nuisance], nuisances: tuple[Term, ...], terms: tuple[Term, ...]
) -> tuple[tuple[Term, ...], tuple[Term, ...]]:
    """Nuisances, then terms: what a nuisance took of an effect that is a term goes to the term.

    A delay between samples is interpolated, one of whole samples is not: the fit would not find
    its way back from a nuisance that is full to a term that could take all of it.
    """
    known = {nuisance.term.candidate.key: nuisance.term.at for nuisance in centres}
    fitted = {n.candidate.key: n.at for n in nuisances}
    taken = {key: fitted[key] - at for key, at in known.items() if key in fitted}
    shared = {
        term.candidate.key
        for term in terms
        if len(taken.get(term.candidate.key, ())) == len(term.at)
    }
    kept = tuple(
        n.moved_to(known[n.candidate.key]) if n.candidate.key in shared else n for n in nuisances
    )
    given = tuple(
        term.moved_to(term.at + taken[term.candidate.key]) if term.candidate.key in shared else term
        for term in terms
    )
    return kept, given
