"""Score tests of a library of candidates, and the calibrated p of their maximum."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import chdtrc

from deltactl.diagnosis.observations.readings import BoolArray, FloatArray, IntArray
from deltactl.diagnosis.score_tests.chi2_tail import log_sfs
from deltactl.diagnosis.score_tests.library import Library
from deltactl.diagnosis.score_tests.options import SCORE_TESTS


@dataclass(frozen=True, slots=True, eq=False)
class Scores:
    """Gain in chi-square of each entry (linearised), its step, and the information left."""

    gain: FloatArray
    log_p: FloatArray
    step: list[FloatArray]
    information: list[FloatArray]
    """Per entry the projected Gram matrix, (k, k)."""


class Scorer:
    """Projects the library on what a solution leaves free."""

    def __init__(self, library: Library, variance_inflation: FloatArray | None = None):
        self.library = library
        self.variance_inflation = (
            np.ones(len(library.entries)) if variance_inflation is None else variance_inflation
        )
        self.tolerance_factor = np.ones(len(library.entries))
        """How many times more a score may be by what no robot file promises (`priors`)."""
        self.left_by_measured = np.zeros(len(library.entries))
        """What effects that were measured before may leave of each entry's shape, in chi-square."""
        self.gram = library.gram()

    def project(self, basis: FloatArray, residual: FloatArray) -> tuple[FloatArray, FloatArray]:
        """What columns share with a basis, (c, p), and with what it leaves of a residual, (c,)."""
        white = self.library.white
        left = residual - basis @ (basis.T @ residual)
        both = np.column_stack([basis, left])[: len(white)].astype(np.float32)
        products = np.asarray(white.T @ both, dtype=np.float64)
        return products[:, :-1], products[:, -1]

    def against(self, basis: FloatArray, residual: FloatArray) -> Scores:
        """Scores by a whitened residual (m,) and a basis (m, p) of the tangent that is refitted."""
        shared, along = self.project(basis, residual)
        count = len(self.library.entries)
        gains, ranks = np.zeros(count), np.zeros(count, dtype=np.intp)
        steps: list[FloatArray] = [np.zeros(0)] * count
        infos: list[FloatArray] = [np.zeros((0, 0))] * count
        for numbers, columns in self.alike:
            own = shared[columns]
            full = self.gram[columns[:, :, None], columns[:, None, :]]
            information = full - own @ own.swapaxes(1, 2)
            step, gain, rank = gain_of(information, along[columns], diagonals(full))
            gains[numbers], ranks[numbers] = gain, rank
            for place, number in enumerate(numbers):
                steps[number], infos[number] = step[place], information[place]
        gains /= self.variance_inflation
        beyond = np.maximum(gains - self.left_by_measured, 0.0) / self.tolerance_factor
        return Scores(gains, log_sfs(beyond, ranks), steps, infos)

    @cached_property
    def alike(self) -> list[tuple[IntArray, IntArray]]:
        """Entries with as many columns: their numbers (m,) and their columns (m, k)."""
        parts: dict[int, list[tuple[int, range]]] = {}
        for number, entry in enumerate(self.library.entries):
            parts.setdefault(entry.df, []).append((number, entry.numbers))
        return [
            (np.array([number for number, _ in part]), np.array([columns for _, columns in part]))
            for part in parts.values()
        ]


def gain_of(
    information: FloatArray, along: FloatArray, full: FloatArray
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Step (..., k), gain in chi-square (...) and rank (...) of columns, from their projected
    Gram matrix (..., k, k).

    along: their products with the residual, (..., k). full: squares of their lengths before,
    (..., k).
    """
    frame, usable = _frame(information, full)
    coordinates = (frame.swapaxes(-1, -2) @ along[..., None])[..., 0]
    step = (frame @ coordinates[..., None])[..., 0]
    return step, np.sum(coordinates**2, axis=-1), usable.sum(axis=-1)


def gain_alone(information: FloatArray, along: FloatArray, full: FloatArray) -> tuple[float, int]:
    """Gain and rank of one set of columns, as `gain_of` has them."""
    _, gain, rank = gain_of(information, along, full)
    return float(gain), int(rank)


def diagonals(matrices: FloatArray) -> FloatArray:
    """Diagonals (..., k) of matrices (..., k, k)."""
    return np.diagonal(matrices, axis1=-2, axis2=-1)


def _frame(information: FloatArray, full: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Directions (..., k, k) of unit information among columns, collinear ones 0; which count."""
    scale = np.sqrt(np.maximum(full, 1e-30))
    values, vectors = np.linalg.eigh(information / (scale[..., :, None] * scale[..., None, :]))
    usable = values > SCORE_TESTS.collinear_scores
    length = np.where(usable, 1.0 / np.sqrt(np.where(usable, values, 1.0)), 0.0)
    return vectors * length[..., None, :] / scale[..., :, None], usable


def tolerance_factor(gram: FloatArray, by_tolerances: FloatArray) -> float:
    """How many times more a test's gain may be by build tolerances than by noise alone.

    gram: of the test's columns, (k, k). by_tolerances: their products with the
    `tolerance_columns` of `priors/tolerances.py`, (k, n).
    """
    frame, usable = _frame(gram, np.diag(gram))
    return 1.0 + float(np.sum((frame.T @ by_tolerances) ** 2)) / max(int(usable.sum()), 1)


def explained_by(columns: FloatArray, residual: FloatArray) -> tuple[float, int]:
    """Gain in chi-square of columns (m, k) on a residual (m,), and their rank."""
    return gain_alone(columns.T @ columns, columns.T @ residual, np.sum(columns**2, axis=0))


@dataclass(frozen=True, slots=True)
class Calibration:
    """How many independent tests the library amounts to, from simulated maxima."""

    tests: float

    def p(self, log_p: float) -> float:
        """p of the largest of the library being this small under 'nothing is missing'."""
        smallest = float(np.exp(max(log_p, -700.0)))
        return float(-np.expm1(self.tests * np.log1p(-min(smallest, 1.0 - 1e-12))))


def calibrate(scorer: Scorer, basis: FloatArray) -> Calibration:
    """Draw scores of pure noise with the library's own covariance and look at the smallest p.

    basis: orthonormal, of the tangent of what is always fitted, (m, p).
    """
    white = scorer.library.white
    shared = np.asarray(white.T @ basis[: len(white)].astype(np.float32), dtype=np.float64)
    covariance = scorer.gram - shared @ shared.T
    scale = np.sqrt(np.maximum(np.diag(scorer.gram), 1e-30))
    unit = covariance / np.outer(scale, scale)
    values, vectors = np.linalg.eigh(unit)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    rng = np.random.default_rng(SCORE_TESTS.seed)
    draws = root @ rng.standard_normal((len(values), SCORE_TESTS.draws))
    smallest = np.ones(SCORE_TESTS.draws)
    for _, columns in scorer.alike:
        own, frame = np.linalg.eigh(unit[columns[:, :, None], columns[:, None, :]])
        usable = own > SCORE_TESTS.collinear_scores
        share = np.where(usable, 1.0 / np.where(usable, own, 1.0), 0.0)
        gain = share[:, None, :] @ (frame.swapaxes(1, 2) @ draws[columns]) ** 2
        possible = usable.any(axis=1)
        chances = chdtrc(usable.sum(axis=1)[possible, None], gain[possible, 0])
        smallest = np.minimum(smallest, chances.min(axis=0, initial=1.0))
    tenth = float(np.quantile(smallest, 0.1))
    return Calibration(float(np.log1p(-0.1) / np.log1p(-tenth)))
