"""The fit of the whole library at once, and what it takes out of the noise that it is to show.

Hundreds of columns also follow the noise a little, its slow part most: what they leave has too
small a spread and too short a memory, and scores whitened by that come out too large. By how much
is seen on noise drawn from the estimate itself and treated in the same way.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
from scipy.linalg import lu_factor, lu_solve

from diagnosis.estimation.least_squares import Fitter
from diagnosis.estimation.noise import ChannelNoise, Whitener, estimate, stationary
from diagnosis.estimation.side_by_side import side_by_side
from diagnosis.observations.readings import BoolArray, FloatArray
from diagnosis.score_tests.library import Library

RIDGE = 1e-5
NOISE_DRAWS = 8
LONGEST = 0.9
"""Sum of the coefficients up to which memory is given back: what remembers more than ten readings
is rather a mismatch that no column follows.
"""
NOISE_SEED = 20261121


class Saturated:
    """Least squares of all columns of a whitened library together."""

    def __init__(self, library: Library, fitter: Fitter):
        gram = library.gram()
        self.library = library
        self.fitter = fitter
        self.scale = np.sqrt(np.maximum(np.diag(gram), 1e-30))
        matrix = gram / np.outer(self.scale, self.scale) + RIDGE * np.eye(len(gram))
        self.factor = lu_factor(matrix, overwrite_a=True)

    def __call__(self, residual: FloatArray) -> FloatArray:
        """What the whole library explains of residuals, (n, channels) or (n, channels, k)."""
        white = self.fitter.whiten(residual).astype(np.float32)
        along = np.asarray(self.library.white.T @ white, dtype=np.float64)
        weights = (lu_solve(self.factor, (along.T / self.scale).T).T / self.scale).T
        return self.library.explained(weights)


def given_back(fit: Saturated, whiten: Whitener, valid: BoolArray) -> tuple[Whitener, FloatArray]:
    """A noise model of what a fit has left, with the memory and spread that the fit took from it.

    Also how many times larger than what is left the noise is, (channels,).
    """
    readings = fit.fitter.model.readings
    rng = np.random.default_rng(NOISE_SEED)
    drawn = np.stack([whiten.drawn(rng, len(readings.t_s)) for _ in range(NOISE_DRAWS)], axis=2)
    left = drawn - fit(drawn)

    def sized(residual: FloatArray) -> list[ChannelNoise]:
        """Without the rows, which are large and the same in all."""
        noise = estimate(readings, valid, residual).channels
        return [replace(one, rows=one.rows[:0]) for one in noise]

    each = [*np.moveaxis(drawn, 2, 0), *np.moveaxis(left, 2, 0)]
    sizes = side_by_side([partial(sized, residual) for residual in each])
    before, after = sizes[:NOISE_DRAWS], sizes[NOISE_DRAWS:]
    channels, larger = [], []
    for number, noise in enumerate(whiten.channels):
        pairs = [(b[number], a[number]) for b, a in zip(before, after, strict=True)]
        taken = np.mean([b.phi - a.phi for b, a in pairs], axis=0)
        louder = _ratio([(b.sigma, a.sigma) for b, a in pairs])
        wider = _ratio([(b.spread, a.spread) for b, a in pairs])
        share = _share(noise.phi, taken)
        larger.append(louder + share * (wider - louder))
        channels.append(
            replace(
                noise,
                phi=stationary(noise.phi + share * taken),
                sigma=noise.sigma * louder,
                spread=noise.spread * larger[-1],
            )
        )
    return Whitener(tuple(channels), whiten.weight), np.array(larger)


def _ratio(pairs: list[tuple[float, float]]) -> float:
    before, after = np.mean(pairs, axis=0)
    return float(before / after) if after > 0.0 else 1.0


def _share(phi: FloatArray, taken: FloatArray) -> float:
    """How much of the memory that was taken may be given back, by `LONGEST`."""
    room, more = LONGEST - float(phi.sum()), float(taken.sum())
    return float(np.clip(room / more, 0.0, 1.0)) if more > 0.0 else 1.0
