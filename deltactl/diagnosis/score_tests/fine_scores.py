"""Scores of finely resolved spline terms, of which each reading meets a few columns only."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.estimation.least_squares import Fitter
from deltactl.diagnosis.estimation.side_by_side import side_by_side
from deltactl.diagnosis.estimation.splines import Score, SplineTerm
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.score_tests.chi2_tail import log_sf
from deltactl.diagnosis.score_tests.score_test import gain_alone, tolerance_factor
from deltactl.diagnosis.score_tests.sinusoids import sinusoid_scores


def scores_of(
    shapes: Sequence[SplineTerm],
    fitter: Fitter,
    solution: Solution,
    small: FloatArray | None,
    left_by_measured: float = 0.0,
) -> list[Score]:
    """Each shape's score, and those of the sinusoid_scores.

    small: whitened changes by what no robot file can promise, (m, k). left_by_measured: chi-square
    that effects which were measured before may leave of any shape.
    """
    basis = solution.basis[: fitter.rows]
    # The rows of the priors count too: a shape that takes over lets the nuisances spring back.
    residual = solution.residual
    rest = (residual - solution.basis @ (solution.basis.T @ residual))[: fitter.rows]
    if small is not None:
        small = small - basis @ (basis.T @ small)
    inputs = fitter.inputs  # before the fork

    def score(free: SplineTerm) -> tuple[float, float]:
        columns = inputs[free.location] @ free.basis
        shared = columns.T @ basis
        gram = (columns.T @ columns).toarray()
        left = gram - shared @ shared.T
        gain, rank = gain_alone(left, columns.T @ rest, np.diag(gram))
        factor = 1.0 if small is None else tolerance_factor(left, columns.T @ small)
        return gain, log_sf(max(gain - left_by_measured, 0.0) / factor, rank)

    tasks: list[Callable[[], Any]] = [partial(sinusoid_scores, fitter, solution, left_by_measured)]
    tasks += [partial(score, free) for free in shapes]
    beats, *scores = side_by_side(tasks)
    return [*((free, *own) for free, own in zip(shapes, scores, strict=True)), *beats]
