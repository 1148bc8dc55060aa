"""Score tests of the whole bank against a fitted model, and the calibrated p of their maximum."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc

from diagnosis.bank import Bank
from diagnosis.chance import log_sf
from diagnosis.orthonormal import orthonormal
from diagnosis.readings import FloatArray

DRAWS = 1000
SEED = 20260101
BLOCK_S = 1.5
COLLINEAR = 1e-6
"""Share of a column that must be left after projection for a test to be possible."""


@dataclass(frozen=True, slots=True, eq=False)
class Scores:
    """Gain in chi-square of each entry (linearised), its step, and the information left."""

    gain: FloatArray
    log_p: FloatArray
    step: list[FloatArray]
    information: list[FloatArray]
    """Per entry the projected Gram matrix, (k, k)."""


class Scorer:
    """Projects the bank on what a solution leaves free."""

    def __init__(self, bank: Bank, inflation: FloatArray | None = None):
        self.bank = bank
        self.inflation = np.ones(len(bank.entries)) if inflation is None else inflation
        self.doubt = np.ones(len(bank.entries))
        """How many times more a score may be by what no robot file promises (`exactness.py`)."""
        self.gram = bank.gram()

    def project(self, tangent: FloatArray, residual: FloatArray) -> tuple[FloatArray, FloatArray]:
        """What columns share with the tangent's basis, (c, p), and with what it leaves, (c,)."""
        white = self.bank.white
        rows = len(white)
        basis = orthonormal(tangent)
        shared = np.asarray(white.T @ basis[:rows].astype(np.float32), dtype=np.float64)
        left = residual - basis @ (basis.T @ residual)
        along = np.asarray(white.T @ left[:rows].astype(np.float32), dtype=np.float64)
        return shared, along

    def against(self, tangent: FloatArray, residual: FloatArray) -> Scores:
        """Scores given a whitened residual (m,) and the tangent (m, p) of what is refitted."""
        shared, along = self.project(tangent, residual)
        gains, ranks, steps, infos = [], [], [], []
        for number, entry in enumerate(self.bank.entries):
            part = entry.columns
            information = self.gram[part, part] - shared[part] @ shared[part].T
            step, gain, rank = gain_of(information, along[part], np.diag(self.gram[part, part]))
            gain /= self.inflation[number]
            gains.append(gain)
            steps.append(step)
            infos.append(information)
            ranks.append(rank)
        degrees = np.array(ranks)
        sure = np.array(gains) / self.doubt
        logs = np.array([log_sf(g, int(d)) for g, d in zip(sure, degrees, strict=True)])
        return Scores(np.array(gains), logs, steps, infos)


def gain_of(
    information: FloatArray, along: FloatArray, full: FloatArray
) -> tuple[FloatArray, float, int]:
    """Step (k,), gain in chi-square and rank of columns, from their projected Gram matrix (k, k).

    along: their products with the residual, (k,). full: squares of their lengths before, (k,).
    """
    frame = _frame(information, full)
    coordinates = frame.T @ along
    return frame @ coordinates, float(coordinates @ coordinates), frame.shape[1]


def _frame(information: FloatArray, full: FloatArray) -> FloatArray:
    """Directions (k, rank) of unit information among columns, the collinear left out."""
    scale = np.sqrt(np.maximum(full, 1e-30))
    values, vectors = np.linalg.eigh(information / np.outer(scale, scale))
    usable = values > COLLINEAR
    frame: FloatArray = vectors[:, usable] / np.sqrt(values[usable]) / scale[:, None]
    return frame


def doubt(gram: FloatArray, with_small: FloatArray) -> float:
    """How many times more a test's gain may be by small errors than by noise alone.

    gram: of the test's columns, (k, k). with_small: their products with the `small_errors` of
    `exactness.py`, (k, n).
    """
    frame = _frame(gram, np.diag(gram))
    return 1.0 + float(np.sum((frame.T @ with_small) ** 2)) / max(frame.shape[1], 1)


def explained_by(columns: FloatArray, residual: FloatArray) -> tuple[float, int]:
    """Gain in chi-square of columns (m, k) on a residual (m,), and their rank."""
    _, gain, rank = gain_of(columns.T @ columns, columns.T @ residual, np.sum(columns**2, axis=0))
    return gain, rank


@dataclass(frozen=True, slots=True)
class Calibration:
    """How many independent tests the bank amounts to, from simulated maxima."""

    tests: float

    def p(self, log_p: float) -> float:
        """p of the largest of the bank being this small under 'nothing is missing'."""
        smallest = float(np.exp(max(log_p, -700.0)))
        return float(-np.expm1(self.tests * np.log1p(-min(smallest, 1.0 - 1e-12))))


def calibrate(scorer: Scorer, tangent: FloatArray) -> Calibration:
    """Draw scores of pure noise with the bank's own covariance and look at the smallest p."""
    basis = orthonormal(tangent)[: len(scorer.bank.white)].astype(np.float32)
    shared = np.asarray(scorer.bank.white.T @ basis, dtype=np.float64)
    covariance = scorer.gram - shared @ shared.T
    scale = np.sqrt(np.maximum(np.diag(scorer.gram), 1e-30))
    values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    draws = root @ np.random.default_rng(SEED).standard_normal((len(values), DRAWS))
    smallest = np.ones(DRAWS)
    for entry in scorer.bank.entries:
        part = entry.columns
        block = (covariance / np.outer(scale, scale))[part, part]
        own, frame = np.linalg.eigh(block)
        usable = own > COLLINEAR
        if not usable.any():
            continue
        gain = np.sum((frame[:, usable].T @ draws[part]) ** 2 / own[usable, None], axis=0)
        smallest = np.minimum(smallest, chdtrc(int(usable.sum()), gain))
    tenth = float(np.quantile(smallest, 0.1))
    return Calibration(float(np.log1p(-0.1) / np.log1p(-tenth)))
