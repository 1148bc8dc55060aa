"""Scores of what is too fine for most of the library: splines and sinusoids.

Each reading meets a few columns of a finely resolved spline only. An error that comes and goes in
time (a table that sways, a lamp that flickers) would take so fine a spline that it followed noise.
A line in the spectrum of the residual needs three numbers only: how often, and how much of sine
and cosine.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.estimation.least_squares import Fitter
from deltactl.diagnosis.estimation.side_by_side import side_by_side
from deltactl.diagnosis.estimation.splines import Score, SplineTerm, waves
from deltactl.diagnosis.observations.readings import BoolArray, FloatArray, IntArray
from deltactl.diagnosis.score_tests.chi2_tail import log_sf
from deltactl.diagnosis.score_tests.options import SCORE_TESTS
from deltactl.diagnosis.score_tests.score_test import explained_by, gain_alone, tolerance_factor


def scores_of(
    shapes: Sequence[SplineTerm],
    fitter: Fitter,
    solution: Solution,
    small: FloatArray | None,
    left_by_measured: float = 0.0,
) -> list[Score]:
    """Each shape's score, and those of the sinusoids.

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

    tasks: list[Callable[[], Any]] = [partial(_sinusoid_scores, fitter, solution, left_by_measured)]
    tasks += [partial(score, free) for free in shapes]
    beats, *scores = side_by_side(tasks)
    return [*((free, *own) for free, own in zip(shapes, scores, strict=True)), *beats]


def _sinusoid_scores(
    fitter: Fitter, solution: Solution, left_by_measured: float = 0.0
) -> list[Score]:
    """At each location the sinusoid that explains most: term, gain, log p for all frequencies.

    left_by_measured: as `scores_of` has it.
    """
    inputs = fitter.model.inputs()
    t_s = fitter.model.readings.t_s
    basis, residual = solution.basis, solution.residual
    found = []
    for location, change in inputs.items():
        rate_hz, looks = _strongest(fitter, residual[: fitter.rows], change)
        if rate_hz is None:
            continue
        free = SplineTerm(location, "time", waves(t_s, rate_hz), t_s[:0], "sinusoid", rate_hz)
        columns = fitter.vector(free.columns(change))
        gain, rank = explained_by(columns - basis @ (basis.T @ columns), residual)
        log_p = log_sf(max(gain - left_by_measured, 0.0), rank) + float(np.log(looks))
        found.append((free, gain, min(log_p, 0.0)))
    return sorted(found, key=lambda item: item[2])


def _strongest(
    fitter: Fitter, residual: FloatArray, change: FloatArray
) -> tuple[float | None, int]:
    """Frequency with most power in a residual seen through a location, and how many were tried."""
    readings, whiten = fitter.model.readings, fitter.whiten
    at = np.rint((readings.t_s[whiten.rows] - readings.t_s[0]) / readings.period_s).astype(int)
    sigma = np.array([noise.sigma for noise in whiten.channels])
    pull = change[whiten.rows, whiten.channel] / sigma[whiten.channel]
    power = float(pull @ pull)
    if power == 0.0:
        return None, 0
    near = _fullest(at)
    at = at[near] - at[near].min()
    length = int(at.max()) + 1
    series = np.asarray(np.bincount(at, (pull * residual)[near], length), dtype=np.float64)
    size = int(2 ** np.ceil(np.log2(SCORE_TESTS.finer * length)))
    lines = np.abs(np.fft.rfft(series, size)) ** 2
    first = int(np.ceil(SCORE_TESTS.fewest_turns * size / length))
    last = int(SCORE_TESTS.fastest * size)
    if last <= first:
        return None, 0
    best = first + int(np.argmax(lines[first:last]))
    # Between the lines, where a quarter of one already leaves a rest.
    turns: FloatArray = (best + np.linspace(-1.0, 1.0, 2 * SCORE_TESTS.between + 1)) / size
    nearest = float(turns[np.argmax(_strength(series, turns))])
    return nearest / readings.period_s, last - first


def _fullest(at: IntArray) -> slice | BoolArray:
    """The stretch of sample numbers with most rows in it; all where they are not too many."""
    if at.max() - at.min() < SCORE_TESTS.most_transformed:
        return slice(None)
    ordered = np.sort(at)
    ends = np.searchsorted(ordered, ordered + SCORE_TESTS.most_transformed)
    first = ordered[np.argmax(ends - np.arange(len(ordered)))]
    return np.asarray((at >= first) & (at < first + SCORE_TESTS.most_transformed), dtype=np.bool_)


def _strength(series: FloatArray, turns: FloatArray) -> FloatArray:
    """Size of a series' part at frequencies (k,) that lie equally far apart, in turns a sample."""
    samples = np.arange(len(series))
    wave = np.exp(-2j * np.pi * turns[0] * samples)
    further = np.exp(-2j * np.pi * (turns[1] - turns[0]) * samples)
    strength = np.empty(len(turns))
    for k in range(len(turns)):
        strength[k] = np.abs(wave @ series)
        wave *= further
    return strength
