"""Terms that no machine can have: they are taken out and the rest is fitted again."""

from __future__ import annotations

from dataclasses import replace

from diagnosis.answer.options import VERDICT
from diagnosis.estimation.estimate import Solution, without
from diagnosis.plants.candidate import Term
from diagnosis.selection.ambiguity import stands_of
from diagnosis.selection.credible_set import credible
from diagnosis.selection.model_choice import Explained


def impossible(term: Term) -> bool:
    """Whether a term cannot be a finding: less than one lost step, no size, or one at its bound.

    A size at its bound is one that the fit would take beyond what the field holds possible:
    something else acts. A second number at its bound (a shaft that does not yield, no dead time) is
    part of the effect.
    """
    candidate = term.candidate
    main = candidate.kind.main.name
    if candidate.effect == "lost_steps":
        return bool(abs(float(candidate.values(term.at)[main])) < VERDICT.least_steps)
    pairs = list(zip(candidate.coordinates, term.at.tolist(), strict=True))
    plain = [at for coordinate, at in pairs if coordinate.how == "plain"]
    if plain and candidate.kind.nothing == 0.0 and not any(plain):
        return True
    return any(
        at in (coordinate.low, coordinate.high) and at != candidate.kind.nothing
        for coordinate, at in pairs
        if coordinate.parameter == main and coordinate.how not in ("frozen", "reciprocal")
    )


def first_impossible(solution: Solution) -> int | None:
    """Number of the first such term; None when all are possible."""
    return next((i for i, term in enumerate(solution.terms) if impossible(term)), None)


def less(explained: Explained, number: int) -> Explained:
    """An explanation without one of its terms, the rest fitted again."""
    search, old = explained.search, explained.solution
    solution = search.fitter.solve(without(old.terms, number), old.frees, old.nuisances)
    stands = stands_of(search, solution)
    chances = credible(search, solution, stands)
    return replace(explained, solution=solution, stands=stands, credible=chances)
