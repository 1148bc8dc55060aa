"""Where and when an effect that acts only now and then leaves the robot alone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import maximum_filter1d

from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.estimation.least_squares import Fitter
from deltactl.diagnosis.observations.readings import BoolArray
from deltactl.diagnosis.plants.candidate import Term
from deltactl.diagnosis.priors.options import OPTIONS


def local_terms(terms: Sequence[Term]) -> tuple[Term, ...]:
    """Those of the terms that act only now and then."""
    return tuple(term for term in terms if term.candidate.kind.local)


def left_alone(fitter: Fitter, solution: Solution) -> BoolArray:
    """Whitened readings (rows,) far from where the solution's local terms act."""
    model = fitter.model
    others = [term for term in solution.terms if not term.candidate.kind.local]
    without = model.predict([*solution.nuisances, *others])
    everything = model.predict([*solution.nuisances, *solution.terms])
    acts = np.abs(everything - without).max(axis=1) > OPTIONS.least_contact_m
    near = maximum_filter1d(acts, 1 + 2 * round(OPTIONS.around_contact_s / model.readings.period_s))
    alone: BoolArray = ~near[fitter.whiten.rows]
    return alone


def clear_rows(fitter: Fitter, one: Solution, other: Solution) -> BoolArray:
    """Whitened readings (rows,) by which to compare two explanations of one recording.

    Those that no local term of either touches; all of them where too few would be left.
    """
    if not local_terms((*one.terms, *other.terms)):
        return np.ones(fitter.rows, dtype=bool)
    clear = left_alone(fitter, one) & left_alone(fitter, other)
    return clear if clear.mean() >= OPTIONS.least_clear else np.ones(fitter.rows, dtype=bool)


def left_near_contact(solution: Solution, clear: BoolArray) -> float:
    """Chi-square left in the readings that are not clear."""
    return float(np.sum(solution.residual[: len(clear)][~clear] ** 2))


def gain_elsewhere(fitter: Fitter, before: Solution, after: Solution) -> float:
    """Chi-square gained in the readings that no local term of either touches."""
    clear = clear_rows(fitter, before, after)
    gained = (
        before.cost
        - left_near_contact(before, clear)
        - after.cost
        + left_near_contact(after, clear)
    )
    return 0.0 if clear.all() else gained
