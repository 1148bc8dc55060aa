"""What this recording cannot tell from a finding: every alternative is refitted and compared."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from deltactl.diagnosis.answer.records import Alternative
from deltactl.diagnosis.estimation.budget import Until
from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.plants.candidate import Candidate, Term
from deltactl.diagnosis.plants.shared_parameters import apart, whole_groups
from deltactl.diagnosis.priors.penalties import Trial
from deltactl.diagnosis.score_tests.chi2_tail import log_sf
from deltactl.diagnosis.search.begun_fits import followed, promising, tried
from deltactl.diagnosis.search.removal import each_left_out
from deltactl.diagnosis.search.search import Search
from deltactl.models.effects import card_of
from deltactl.models.effects.card import Equal, Sizes


@dataclass(frozen=True, slots=True, eq=False)
class Standing:
    """The leave-one-out result of a finding: loss, p and alternatives."""

    gain: float
    p: float
    alternatives: list[Alternative]
    refits: list[Solution]
    """What was fitted with each alternative in its place, the closest first.

    A group (`together`) is one alternative and several alternatives.
    """


def resolved(search: Search, solution: Solution) -> tuple[Solution, list[Standing]]:
    """Leave-one-out result of each term; an alternative with a lower penalised cost becomes the
    finding."""
    cost = search.criterion.penalised
    for _ in range(search.options.most_swaps_of_ties):
        stands = stands_of(search, solution)
        refits = [refit for stand in stands for refit in stand.refits]
        best = min(refits, key=cost, default=solution)
        stays = cost(best) > cost(solution) - search.options.better
        if stays or not search.budget.lasts(Until.RESOLVED):
            return solution, stands
        solution = in_parts(search, with_changes(search, solution, best))
    return solution, stands_of(search, solution)


def with_changes(search: Search, solution: Solution, refit: Solution) -> Solution:
    """An alternative beside the measured effects in whose place it is, where they have changed all
    the
    same: what fits better in all explains no change of what is known.
    """
    there = {term.candidate.key for term in refit.terms}
    changed = tuple(
        term
        for term in solution.terms
        if term.candidate.key not in there and search.tests.changed(refit, term.candidate.key)
    )
    if not changed:
        return refit
    return search.fitter.solve((*refit.terms, *changed), refit.frees, refit.nuisances)


def in_parts(search: Search, solution: Solution) -> Solution:
    """Groups as their members, which may now differ a little."""
    if not any(term.candidate.members for term in solution.terms):
        return solution
    terms = apart(solution.terms, search.prepared.model.candidates)
    return search.fitter.solve(terms, solution.frees, solution.nuisances)


def stands_of(search: Search, solution: Solution) -> list[Standing]:
    """Leave-one-out results of the terms, in their order; members of a whole group also as one."""
    count, groups = len(solution.terms), whole_groups(solution.terms)
    each = _standing(search, solution, [*((i,) for i in range(count)), *groups])
    stands = each[:count]
    for numbers, whole in zip(groups, each[count:], strict=True):
        offered = [one.model_copy(update={"together": True}) for one in whole.alternatives]
        for place, number in enumerate(numbers):
            own = stands[number]
            refits = [*own.refits, *whole.refits] if place == 0 else own.refits
            stands[number] = replace(
                own, alternatives=_unique([*own.alternatives, *offered]), refits=refits
            )
    return stands


@dataclass(frozen=True, slots=True, eq=False)
class _LeftOut:
    """What is lost without some terms, and where to start what may take their place."""

    own: list[Candidate]
    bare: Solution
    gain: float
    starts: list[Term]


def _standing(search: Search, solution: Solution, each: Sequence[Sequence[int]]) -> list[Standing]:
    """Leave some terms out, refit, and let every other candidate take their place; for each."""
    each_left_out(search, solution)
    cuts = search.fitter.side_by_side(
        [partial(_left_out, search, solution, numbers) for numbers in each]
    )
    refits = [((*cut.bare.terms, start), cut.bare) for cut in cuts for start in cut.starts]
    begun_fits = iter(tried(search.fitter, refits, search.options))
    begun = [
        promising(cut.bare, [next(begun_fits) for _ in cut.starts], search.options) for cut in cuts
    ]
    hopeful = [
        [one for one in ones if one.within_reach(solution, cut.gain, search.options)]
        for cut, ones in zip(cuts, begun, strict=True)
    ]
    others = iter(followed(search.fitter, [one for ones in hopeful for one in ones]))
    return [
        _stands(search, solution, cut, [next(others) for _ in ones])
        for cut, ones in zip(cuts, hopeful, strict=True)
    ]


def _left_out(search: Search, solution: Solution, numbers: Sequence[int]) -> _LeftOut:
    if len(numbers) == 1:
        bare = each_left_out(search, solution)[numbers[0]].fit
    else:
        rest = tuple(term for i, term in enumerate(solution.terms) if i not in numbers)
        bare = search.fitter.solve(rest, solution.frees, solution.nuisances)
    gain = max(bare.cost - solution.cost, 0.0)
    own = [solution.terms[i].candidate for i in numbers]
    return _LeftOut(own, bare, gain, _starts(search, solution, bare, numbers, gain))


def _stands(
    search: Search, solution: Solution, cut: _LeftOut, others: Sequence[Solution]
) -> Standing:
    cost = search.criterion.penalised
    log_p = log_sf(cut.gain, sum(len(one.moved) for one in cut.own))
    refits: list[tuple[Alternative, Candidate, Solution]] = []
    for other in others:
        worse = other.cost - solution.cost
        # An alternative with fewer coordinates is forgiven what the others' freedom gains.
        if min(worse, cost(other) - cost(solution)) < search.options.tied:
            one = other.terms[-1].candidate
            entry = Alternative(
                effect=one.effect, component=one.component, delta_chi2=max(worse, 0.0)
            )
            refits.append((entry, one, other))
    refits.sort(key=lambda found: found[2].cost)
    alternatives = [line for entry, one, _ in refits for line in _members(entry, one)]
    return Standing(
        cut.gain, search.tests.p(log_p), _unique(alternatives), [found[2] for found in refits]
    )


def _starts(
    search: Search, solution: Solution, bare: Solution, numbers: Sequence[int], gain: float
) -> list[Term]:
    """Where to start each alternative: equivalents_of of what was left out, then what scores
    best."""
    left_out = [solution.terms[i] for i in numbers]
    model = search.prepared.model
    known = equivalents_of(left_out, [*model.candidates, *model.groups])
    converted = {term.candidate.key for term in known}
    effects = {term.candidate.effect for term in left_out}
    keys = [term.candidate.key for term in left_out]
    least = min(search.options.tie_share * gain, gain - search.options.tie_reach)
    trials = [
        t
        for t in search.tests.trials(bare, keys, groups=True)
        if t.gain > least and not _same(t, effects, numbers)
    ]
    trials.sort(key=lambda t: -t.gain)
    best = [
        t.start
        for t in trials[: search.options.ties_refitted]
        if t.start.candidate.key not in converted
    ]
    return [*known, *best]


def _same(trial: Trial, effects: set[str], numbers: Sequence[int]) -> bool:
    """The finding's own effect at all arms, or at one of the arms of a whole group."""
    own = trial.start.candidate.effect in effects
    return own and (bool(trial.start.candidate.members) or len(numbers) > 1)


def _members(entry: Alternative, candidate: Candidate) -> list[Alternative]:
    """A group as one line for each member."""
    if not candidate.members:
        return [entry]
    together = {"together": True}
    return [entry.model_copy(update={"component": name, **together}) for name in candidate.members]


def _unique(alternatives: Sequence[Alternative]) -> list[Alternative]:
    """One line for each effect and component, the closest."""
    best: dict[tuple[str, str], Alternative] = {}
    for one in sorted(alternatives, key=lambda a: a.delta_chi2):
        best.setdefault((one.effect, one.component), one)
    return list(best.values())


def equivalents_of(terms: Sequence[Term], candidates: Sequence[Candidate]) -> list[Term]:
    """The candidates where they do what the terms do together, as their card has it (`equals`)."""
    effects = {term.candidate.effect for term in terms}
    if len(effects) != 1:
        return []
    equals = {one.other: one for one in card_of(effects.pop()).equals}
    return [
        Term(other, at)
        for other in candidates
        if (equal := equals.get(other.effect)) and _in_place(equal, terms, other)
        for at in _sizes(equal, terms, other)
    ]


def _in_place(equal: Equal, terms: Sequence[Term], other: Candidate) -> bool:
    if equal.common:
        return bool(other.members) or len(terms) > 1
    return len(terms) == 1 and other.component == terms[0].candidate.component


def _sizes(equal: Equal, terms: Sequence[Term], other: Candidate) -> list[np.ndarray[Any, Any]]:
    """Coordinates of the other; of several terms the mean. None where it has others, or no size."""
    every = [
        equal.sizes(_numbers(term.candidate.values(term.at)), _numbers(other.fixed))
        for term in terms
    ]
    names = [coordinate.parameter for coordinate in other.coordinates]
    if any(set(sizes) != {*names} for sizes in every[0]):
        return []
    at = np.mean([[[sizes[name] for name in names] for sizes in sets] for sets in every], axis=0)
    return list(at) if np.any(at) else []


def _numbers(values: Mapping[str, Any]) -> Sizes:
    return {name: float(x) for name, x in values.items() if np.ndim(x) == 0}
