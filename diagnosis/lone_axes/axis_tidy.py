"""The plainest form of an explanation: what fits alike with fewer numbers is said with fewer."""

from __future__ import annotations

import numpy as np

from diagnosis.estimation.estimate import Solution
from diagnosis.estimation.least_squares import Fitter
from diagnosis.plants import axis_candidates as moves
from diagnosis.plants.candidate import Candidate, Term

PARTS = ("time", "dead_time")
ALIKE = 8.0
"""Scaled chi-square by which a plainer form may fit worse."""


def tidied(fitter: Fitter, solution: Solution, scale: float) -> Solution:
    """Late drives as one first-order lag, one dead time, or both if the recording shows both."""
    for number, term in enumerate(solution.terms):
        if term.candidate.effect not in ("following_lag", "sensor_latency"):
            continue
        forms = [_refitted(fitter, solution, number, start) for start in _forms(fitter, term)]
        if not forms:
            continue
        best = min([solution, *forms], key=lambda s: s.cost)
        for form in forms:
            if form.cost - best.cost < ALIKE * scale:
                return form
        return best
    return solution


def _forms(fitter: Fitter, term: Term) -> list[Term]:
    """The same lateness in plainer forms, the one that is preferred first."""
    kinds = [c.kind for c in fitter.model.candidates if c.effect == "following_lag"]
    if not kinds:
        return []
    late_s = float(sum(term.at))
    parts = [moves.part_of_lag(kinds[0], fitter.model.readings.period_s, p) for p in PARTS]
    return [_at(part, late_s) for part in parts]


def _at(candidate: Candidate, late_s: float) -> Term:
    return Term(candidate, np.array([late_s])).moved_to(np.array([late_s]))


def _refitted(fitter: Fitter, solution: Solution, number: int, start: Term) -> Solution:
    terms = (*solution.terms[:number], start, *solution.terms[number + 1 :])
    return fitter.solve(terms, solution.frees, solution.nuisances)
