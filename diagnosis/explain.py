"""Which explanation to believe: few effects, few effects on a loosely built machine, or unknown."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from diagnosis.candidate import Term
from diagnosis.challenge import challenge, free_rivals
from diagnosis.detect import ALPHA, Progress
from diagnosis.elsewhere import blurred, clear_rows
from diagnosis.fit import Fitter
from diagnosis.name import CHOICE, Search
from diagnosis.noise import Whitener, estimate
from diagnosis.prepare import Prepared, once_more
from diagnosis.readings import BoolArray, FloatArray
from diagnosis.settle import Standing, in_parts, settle
from diagnosis.solution import Solution
from diagnosis.usual import usual

PROMOTED = 12.0
"""Chi-square that lifting the prior of a tolerance must gain to make it a finding."""
MOST_FREES = 2
CALMER = 0.99
"""Noise that shrinks by more than this once an explanation is found had mismatch in it."""
MOST_ROUNDS = 3
MOST_REFITS = 6
PILE = 3
"""From so many effects on, small errors everywhere are the likelier story."""


@dataclass(frozen=True, slots=True, eq=False)
class Explained:
    """The outcome: a search (with its fitter) and the solution it settled on."""

    search: Search
    solution: Solution
    first_p: float
    """Calibrated p of 'nothing is missing' before any finding."""
    loosely_built: bool
    """Small errors of the build are fitted everywhere beside the findings."""
    nominal: Solution
    """The machine of the robot file, without even the tolerances."""
    stands: list[Standing]
    """How each term of the solution stands against its rivals, in their order."""


def explain(prepared: Prepared, rad_per_step: float, progress: Progress) -> Explained:
    """Search for few effects; then let tolerances everywhere and free shapes compete."""
    search = Search(prepared, rad_per_step, progress)
    first_p = search.first_p()
    search, solution = calmed(search, search.run())
    search.prepared.bank.forget_raw()
    nominal = search.empty
    solution, beside = _reviewed(search, solution)
    loose = None if beside is None else _loose(search, solution, beside)
    search, solution = loose or (search, solution)
    challenged = in_parts(search, _challenged(search, solution))
    progress("what else it could be")
    settled, stands = settle(search, challenged)
    return Explained(search, settled, first_p, loose is not None, nominal, stands)


def _loose(
    search: Search, solution: Solution, beside: tuple[Term, ...]
) -> tuple[Search, Solution] | None:
    """Small errors everywhere with what else these need, where they are the better story.

    When they need nothing the search begins without effects: some of these only do what they do.
    """
    search.progress("comparing with a machine that is a little off everywhere")
    other = _with_tolerances(search)
    begun = beside if other.any_shows(other.trials(other.empty)) else ()
    rival = _promoted(other, other.finished(other.resumed(begun, other.empty.nuisances)))
    better = bool(rival.terms) and _looser(search, solution, other, rival)
    return (other, rival) if better else None


def _reviewed(search: Search, solution: Solution) -> tuple[Solution, tuple[Term, ...] | None]:
    """A solution or what is better as two causes for one or as a group; and what of it is needed
    beside small errors everywhere, where these may be better still.

    Most solutions stay as they are: all is asked at the same time.
    """
    doubted = search.doubted(solution)
    tasks: list[Callable[[], Any]] = [
        partial(_gives_way, search, solution),
        partial(search.group_instead, solution),
        *doubted,
    ]
    gives_way, group, *pairs = search.fitter.side_by_side(tasks)
    finished = search.best_pair(solution, pairs)
    if finished is not solution:
        group = search.group_instead(finished)
    chosen = finished if group is None else group
    return chosen, gives_way if chosen is solution else _gives_way(search, chosen)


def _gives_way(search: Search, solution: Solution) -> tuple[Term, ...] | None:
    """What is needed beside small errors everywhere and is none, if these may be the better story:
    some effect is not needed, or with all of them it is better already.
    """
    if not _looks_loose(search, solution):
        return None
    other = _with_tolerances(search)
    beside = other.fitter.solve(solution.terms, solution.frees)
    needed = other.drop(beside)
    if len(needed.terms) == len(solution.terms) and not _looser(search, solution, other, needed):
        return None
    return tuple(term for term in needed.terms if not usual(search.prepared.model, term))


def _looser(search: Search, solution: Solution, other: Search, rival: Solution) -> bool:
    """Whether small errors everywhere are the better story, judged where nothing local blurs it.

    Not when it is one by an effect that would make the first story as good, and was left out of
    it for what the others blur.
    """
    clear = clear_rows(search.fitter, solution, rival)
    many = blurred(rival, clear)
    evidence, story = _evidence(other, rival) - many, other.story(rival) - many

    def beats(one: Solution) -> bool:
        few = blurred(one, clear)
        small = _small(search, one) and story < search.story(one) - few
        return small or evidence < _evidence(search, one) - few

    if not beats(solution):
        return False
    fairer = _with_those_of(search, solution, rival)
    return fairer is solution or beats(fairer)


def _with_those_of(search: Search, solution: Solution, rival: Solution) -> Solution:
    """A solution with what another has beside it, where that was left out for the blur alone."""
    own = {term.candidate.key for term in solution.terms}
    more = [term for term in rival.terms if term.candidate.key not in own]
    if not more:
        return solution
    both = search.fitter.solve((*solution.terms, *more), solution.frees, solution.nuisances)
    most = max(search.least_gain(solution, term.candidate) for term in more)
    return both if solution.cost - both.cost < most else solution


def calmed(search: Search, solution: Solution) -> tuple[Search, Solution]:
    """Search on where the noise had mismatch in it: what rings or sticks looks like noise with a
    memory, and whitening by that takes it, and much beside it, away.
    """
    for _ in range(MOST_ROUNDS):
        prepared = search.prepared
        if not solution.terms or not _calmer(
            left_noise(search.fitter, solution, prepared.valid), search.fitter.whiten
        ):
            break
        search.progress("noise of the readings, once more")
        again = once_more(prepared, solution.predicted)
        search = Search(again, search.rad_per_step, search.progress, search.calibration)
        solution = search.resumed(solution.terms, solution.nuisances)
    return search, solution


def left_noise(fitter: Fitter, solution: Solution, valid: BoolArray) -> Whitener:
    """Noise model of what a solution leaves."""
    left: FloatArray = fitter.observed - solution.predicted
    return estimate(fitter.model.readings, valid, left)


def _calmer(new: Whitener, old: Whitener) -> bool:
    """Whether any channel is less noisy than was thought."""
    pairs = zip(new.channels, old.channels, strict=True)
    return any(len(a.rows) and a.sigma < CALMER * b.sigma for a, b in pairs)


def _challenged(search: Search, solution: Solution) -> Solution:
    """Free shapes beside or instead of the named effects, as long as one more earns its place.

    What one shape leaves at its own port is its blur and earns no second one there.
    """
    for _ in range(MOST_FREES):
        if not solution.terms and not solution.frees and search.first_p() > ALPHA:
            return solution
        taken = {free.port for free in solution.frees}
        if taken and all(free.port in taken for free in free_rivals(search, solution)):
            return solution
        challenged = challenge(search, solution)
        if len(challenged.frees) == len(solution.frees):
            return challenged
        if len({free.port for free in challenged.frees}) < len(challenged.frees):
            return solution
        solution = challenged
    return solution


def _looks_loose(search: Search, solution: Solution) -> bool:
    """A pile of effects, or a rest that a wrong size of the machine would explain."""
    tolerances = {n.term.candidate.effect for n in search.prepared.model.tolerances}
    if not solution.terms or not tolerances:
        return False
    rest = search.trials(solution)
    static = bool(rest) and rest[0].start.candidate.effect in tolerances
    rest_is_static = static and search.p(rest[0].log_p) < ALPHA
    return len(solution.terms) >= PILE or rest_is_static or _small(search, solution)


def _small(search: Search, solution: Solution) -> bool:
    """Whether an error no larger than every machine may have stands beside something else.

    By itself it is a finding; beside a fault it says how the machine was built.
    """
    model = search.prepared.model
    return len(solution.terms) > 1 and any(usual(model, term) for term in solution.terms)


def _promoted(search: Search, solution: Solution) -> Solution:
    """A wrong size that is too far off for a tolerance, though the priors nearly hide it."""
    tolerances = {n.term.candidate.effect for n in search.prepared.model.tolerances}
    tolerances.discard("transmission_error")
    static = [t for t in search.trials(solution) if t.start.candidate.effect in tolerances]
    if not static or static[0].gain < PROMOTED:
        return solution
    grown = search.fitter.solve(
        (*solution.terms, static[0].start), solution.frees, solution.nuisances
    )
    return grown if solution.cost - grown.cost > PROMOTED else solution


def _with_tolerances(search: Search) -> Search:
    prepared = search.prepared
    model = prepared.model
    fitter = Fitter(model, prepared.fitter.whiten, [*model.nuisances, *model.tolerances])
    loose = replace(prepared, fitter=fitter)
    return Search(loose, search.rad_per_step, search.progress, search.calibration)


def _evidence(search: Search, solution: Solution) -> float:
    """Cost with what choosing the terms and fitting the nuisances is worth (Laplace)."""
    fitter = search.fitter
    count = sum(len(t.candidate.moved) for t in solution.nuisances)
    jac = solution.tangent[: fitter.rows, :count] * fitter.spread
    occam = float(np.linalg.slogdet(np.eye(count) + jac.T @ jac)[1])
    return search.worth(solution) + CHOICE * len(solution.terms) + occam


def final_fit(explained: Explained, valid: BoolArray) -> tuple[Fitter, Solution]:
    """Fit again under the noise that the chosen explanation itself leaves, until both agree."""
    fitter, solution = explained.search.fitter, explained.solution
    for _ in range(MOST_REFITS):
        whitener = left_noise(fitter, solution, valid)
        calmer = _calmer(whitener, fitter.whiten)
        fitter = Fitter(fitter.model, whitener, fitter.nuisances)
        solution = fitter.solve(solution.terms, solution.frees, solution.nuisances, steps=4)
        if not calmer:
            break
    return fitter, solution
