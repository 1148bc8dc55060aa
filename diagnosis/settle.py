"""What this recording cannot tell from a finding: every rival is refitted and compared."""

from __future__ import annotations

from dataclasses import dataclass

from diagnosis.chance import log_sf
from diagnosis.fit import Solution
from diagnosis.name import Search
from diagnosis.result import Alternative

LIMIT = 11.0
"""Chi-square within which two explanations count as tied."""
REFITTED = 6


@dataclass(frozen=True, slots=True, eq=False)
class Standing:
    """How a finding stands: what is lost without it, its p, and its rivals."""

    gain: float
    p: float
    alternatives: list[Alternative]
    rivals: list[Solution]
    """What was fitted with each alternative in its place, in the same order."""


def standing(search: Search, solution: Solution, number: int) -> Standing:
    """Leave one term out, refit, and let every other candidate take its place."""
    own = solution.terms[number].candidate
    rest = (*solution.terms[:number], *solution.terms[number + 1 :])
    bare = search.fitter.solve(rest, solution.frees, solution.nuisances, steps=4)
    gain = max(bare.cost - solution.cost, 0.0)
    log_p = log_sf(gain, len(own.moved))
    rivals: list[tuple[Alternative, Solution]] = []
    trials = [t for t in search.trials(bare, [own.key]) if t.gain > min(0.75 * gain, gain - 60.0)]
    for trial in sorted(trials, key=lambda t: -t.gain)[:REFITTED]:
        other = search.fitter.solve((*rest, trial.start), solution.frees, bare.nuisances)
        worse = other.cost - solution.cost
        if worse < LIMIT:
            candidate = trial.start.candidate
            rival = Alternative(
                effect=candidate.effect, component=candidate.component, delta_chi2=worse
            )
            rivals.append((rival, other))
    rivals.sort(key=lambda pair: pair[0].delta_chi2)
    return Standing(
        gain, search.p(log_p), [rival for rival, _ in rivals], [fitted for _, fitted in rivals]
    )
