"""What a recording of a lone axis cannot tell from a finding."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from diagnosis.answer.records import Alternative
from diagnosis.estimation.estimate import Solution
from diagnosis.lone_axes.axis_search import AxisSearch
from diagnosis.plants.candidate import Candidate, Term

LIMIT = 9.0
"""Scaled chi-square within which two explanations count as tied."""
STEADY = 2.5
ROUGH = 1.3
"""From so much more than noise on, chi-squares alone do not tell explanations apart."""
REFITTED = 5
TWINS = {
    "gear_backlash": "joint_friction",
    "joint_friction": "gear_backlash",
    "transmission_error": "encoder_error",
    "encoder_error": "transmission_error",
}
"""Operators with the same coordinates: one starts where the other ended."""


def rivals(
    search: AxisSearch, solution: Solution, number: int, bare: Solution
) -> list[Alternative]:
    """Every other candidate takes the finding's place and all is refitted; those that tie."""
    own = solution.terms[number]
    rest = (*solution.terms[:number], *solution.terms[number + 1 :])
    found: dict[str, float] = {}
    for start in _starts(search, solution, own, bare):
        other = search.fitter.solve((*rest, start), solution.frees, solution.nuisances)
        worse = (other.cost - solution.cost) / search.excess(solution)
        effect = start.candidate.effect
        if effect == own.candidate.effect:
            continue
        if _ties(search, solution, bare, other, worse) and worse < found.get(effect, np.inf):
            found[effect] = max(worse, 0.0)
    for effect in _same_by_construction(search, solution, own.candidate):
        found.setdefault(effect, 0.0)
    return [
        Alternative(effect=effect, component=own.candidate.component, delta_chi2=worse)
        for effect, worse in sorted(found.items(), key=lambda item: item[1])
    ]


def _ties(
    search: AxisSearch, solution: Solution, bare: Solution, other: Solution, worse: float
) -> bool:
    if worse < LIMIT:
        return True
    if search.excess(solution) < ROUGH:
        return False
    gain = (bare.cost - solution.cost) / search.excess(solution)
    return worse < 0.05 * gain and search.steadiness(other, solution) < STEADY


def _starts(search: AxisSearch, solution: Solution, own: Term, bare: Solution) -> list[Term]:
    taken = {term.candidate.key for term in solution.terms}
    starts = []
    for candidate in search.prepared.model.candidates:
        if candidate.key in taken:
            continue
        if TWINS.get(own.candidate.effect) == candidate.effect and len(own.at) == len(
            candidate.coordinates
        ):
            starts.append(Term(candidate, own.at.copy()))
        if own.candidate.effect == "following_lag" and candidate.effect == "sensor_latency":
            starts.append(Term(candidate, np.array([float(own.at.sum())])))
    trials = search.trials(bare, [own.candidate.key])
    equivalents_of = {start.candidate.key for start in starts}
    starts += [t.start for t in trials[:REFITTED] if t.start.candidate.key not in equivalents_of]
    return starts


def _same_by_construction(search: AxisSearch, solution: Solution, own: Candidate) -> Sequence[str]:
    """Explanations that no recording of these columns could tell apart."""
    model = search.prepared.model
    effects = {term.candidate.effect for term in solution.terms}
    offered = {candidate.effect for candidate in model.candidates}
    if own.effect == "effort_offset" and "joint_friction" in effects:
        return ["joint_friction"]  # its asymmetry: more friction one way than the other
    if own.effect == "following_lag" and "effort_gain" not in offered:
        lags = any(coordinate.parameter == "time" for coordinate in own.coordinates)
        return ["viscous_friction"] if lags and "viscous_friction" not in offered else []
    if own.effect == "home_offset" and "joint_compliance" not in offered:
        return (
            [] if search.rad_per_step else ["joint_compliance"]
        )  # a constant load that is unknown
    return []
