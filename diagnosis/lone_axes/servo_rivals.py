"""What else could stand in a finding's place, at whichever joint: better, or as well."""

from __future__ import annotations

from diagnosis.answer.records import Alternative, Finding
from diagnosis.estimation.estimate import Solution
from diagnosis.lone_axes.axis_answer import AxisOutcome
from diagnosis.lone_axes.axis_search import AxisSearch

LIMIT = 9.0
"""Scaled chi-square within which two explanations count as tied."""
REFITTED = 8
BETTER = 1.0
"""Scaled chi-square, tolls counted, by which another term must be better to take a place."""
ROUNDS = 4


def swapped(search: AxisSearch, solution: Solution) -> Solution:
    """The search adds the best term first; with others beside it another may be better."""
    for _ in range(ROUNDS if len(solution.terms) > 1 else 0):
        better = _better(search, solution)
        if better is None:
            break
        solution = better
    return solution


def _better(search: AxisSearch, solution: Solution) -> Solution | None:
    scale = search.excess(solution)
    best, least = None, search.value(solution, scale) - BETTER
    for number, term in enumerate(solution.terms):
        rest = (*solution.terms[:number], *solution.terms[number + 1 :])
        bare = search.fitter.solve(rest, solution.frees, solution.nuisances)
        for trial in search.trials(bare, [term.candidate.key])[:REFITTED]:
            other = search.fitter.solve((*rest, trial.start), solution.frees, solution.nuisances)
            if search.value(other, scale) < least:
                best, least = other, search.value(other, scale)
    return best


def rivals(outcome: AxisOutcome, finding: Finding) -> list[Alternative]:
    """Every other candidate takes the finding's place and all is refitted; those that tie."""
    search, solution = outcome.search, outcome.solution
    key = (finding.effect, finding.component)
    own = [t for t in solution.terms if t.candidate.key == key]
    if not own:
        return []
    rest = tuple(t for t in solution.terms if t.candidate.key != key)
    bare = search.fitter.solve(rest, solution.frees, solution.nuisances)
    found = []
    for trial in search.trials(bare, [key])[:REFITTED]:
        other = search.fitter.solve((*rest, trial.start), solution.frees, solution.nuisances)
        worse = (other.cost - solution.cost) / search.excess(solution)
        if worse < LIMIT:
            found.append(
                Alternative(
                    effect=trial.start.candidate.effect,
                    component=trial.start.candidate.component,
                    delta_chi2=max(worse, 0.0),
                )
            )
    return sorted(found, key=lambda one: one.delta_chi2)
