"""Whether a model error depends on more than the present value of what it follows.

Play, friction and filters remember: the same place or speed gives another error when it was come
to another way. The test adds, beside the shape over the covariate's present value, shapes over its
past values and over the way it came last, and asks what they explain that the present does not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from scipy.sparse import csr_array

from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.estimation.least_squares import Fitter
from deltactl.diagnosis.estimation.options import ESTIMATION
from deltactl.diagnosis.estimation.side_by_side import side_by_side
from deltactl.diagnosis.estimation.splines import SplineTerm, knots_for, spline_basis, two_way
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.priors.options import OPTIONS
from deltactl.diagnosis.score_tests.chi2_tail import log_sf
from deltactl.diagnosis.score_tests.options import SCORE_TESTS
from deltactl.diagnosis.score_tests.score_test import gain_alone

CERTAIN = np.log(SCORE_TESTS.chance)


def has_memory(fitter: Fitter, solution: Solution, free: SplineTerm, gain: float) -> bool | None:
    """Whether the past of a spline term's covariate matters at its location.

    gain: chi-square that the shape explains. None where it is too little to rule a memory out,
    and for time, which has no other past.
    """
    readings = fitter.model.readings
    covariate = fitter.model.covariates()[free.covariate]
    if free.covariate == "time":
        return None
    if free.kind == "way":
        return True
    t_s = readings.t_s
    pasts = [np.interp(t_s - late_s, t_s, covariate) for late_s in SCORE_TESTS.past_s]
    shapes = [replace(free, basis=_shape(past)) for past in pasts]
    shapes.append(replace(free, basis=two_way(covariate, free.basis)))
    found = [_explained(fitter, solution, shape) for shape in shapes]
    if any(log_p < CERTAIN and more > SCORE_TESTS.least_share * gain for more, log_p in found):
        return True
    return False if SCORE_TESTS.least_share * gain > -2.0 * CERTAIN else None


def tied_drivers(
    fitter: Fitter, bare: Solution, free: SplineTerm, shapes: Sequence[SplineTerm]
) -> list[str]:
    """Other covariates that explain at the same location as much as a spline term does, best first.

    bare: the fit without the shape. On a circle an arm's angle tells its speed, and no test on
    that circle can say which of them an error follows.
    """
    if free.kind == "sinusoid":
        return []
    limit = 2.0 * _explained(fitter, bare, free)[1] + OPTIONS.tied
    alternatives = [
        shape
        for shape in shapes
        if (shape.location, shape.kind) == (free.location, free.kind)
        and shape.covariate != free.covariate
    ]
    tasks = [partial(_explained, fitter, bare, shape) for shape in alternatives]
    found: dict[str, float] = {}
    for shape, (_, log_p) in zip(alternatives, side_by_side(tasks), strict=True):
        found[shape.covariate] = min(2.0 * log_p, found.get(shape.covariate, 0.0))
    return sorted((name for name, x in found.items() if x < limit), key=lambda name: found[name])


def _shape(covariate: FloatArray) -> csr_array:
    return spline_basis(covariate, knots_for(covariate, ESTIMATION.pieces))


def _explained(fitter: Fitter, solution: Solution, shape: SplineTerm) -> tuple[float, float]:
    """Chi-square that one more shape explains, and the log of its chance."""
    known = solution.basis
    columns = fitter.free_tangent([shape])
    more = columns - known @ (known.T @ columns)
    full = np.sum(columns**2, axis=0)
    gain, rank = gain_alone(more.T @ more, more.T @ solution.residual, full)
    return gain, log_sf(gain, rank)
