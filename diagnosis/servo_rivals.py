"""What a recording of a servo delta cannot tell from a finding, at whichever joint."""

from __future__ import annotations

from diagnosis.axis_answer import AxisOutcome
from diagnosis.result import Alternative, Finding

LIMIT = 9.0
"""Scaled chi-square within which two explanations count as tied."""
REFITTED = 8


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
