"""Terms that no machine can have: they are taken out and the rest is fitted again."""

from __future__ import annotations

from copy import copy
from dataclasses import replace

import numpy as np

from deltactl.diagnosis.answer.options import VERDICT
from deltactl.diagnosis.assessment import intervals
from deltactl.diagnosis.assessment.intervals import covariance, parameters
from deltactl.diagnosis.estimation.estimate import Solution, without
from deltactl.diagnosis.estimation.least_squares import Fitter
from deltactl.diagnosis.plants.candidate import Term
from deltactl.diagnosis.plants.contract import Model
from deltactl.diagnosis.selection.ambiguity import stands_of
from deltactl.diagnosis.selection.credible_set import credible
from deltactl.diagnosis.selection.model_choice import Explained
from deltactl.models.effects import Trait, has


def impossible(term: Term) -> bool:
    """Whether a term cannot be a finding: less than one lost step, no size, or one at its bound.

    A size at its bound is one that the fit would take beyond what the field holds possible:
    something else acts. A second number at its bound (a shaft that does not yield, no dead time) is
    part of the effect.
    """
    candidate = term.candidate
    main = candidate.kind.main.name
    if has(candidate.effect, Trait.WHOLE_STEPS):
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


def beyond_physics(fitter: Fitter, solution: Solution) -> str | None:
    """The first effect of which even the near end of the interval is more than such a thing has.

    It only fits like one: arms that would shrink by 4.6 % while they warm up are something else.
    """
    for number, term in enumerate(solution.terms):
        kind = term.candidate.kind
        if not np.abs(term.candidate.values(term.at)[kind.main.name]).max() > kind.physical:
            continue
        cov = covariance(fitter, solution)
        part = solution.columns_of(number)
        ends = intervals.by_profile(fitter, solution, number, cov[part, part])
        interval = np.array(parameters(term, cov[part, part], ends)[kind.main.name].ci95, float)
        if (interval > kind.physical).all() or (interval < -kind.physical).all():
            return kind.name
    return None


def lacking(model: Model, effect: str) -> Model:
    """The same machine and readings, where that effect is no candidate."""
    other = copy(model)
    other.candidates = [candidate for candidate in model.candidates if candidate.effect != effect]
    other.groups = [group for group in model.groups if group.effect != effect]
    return other
