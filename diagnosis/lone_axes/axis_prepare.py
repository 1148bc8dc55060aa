"""Noise model of a lone axis: from a saturated fit by plain least squares.

The engine's own preparation whitens while it saturates, which is right for noisy ranges. Encoders
have next to no noise, and what a model leaves there is slow: whitened away, it would come back as
anything. Here the saturated fit is plain, and the correlation that is taken for noise is short.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import median_filter

from diagnosis.estimation.blocks import blocks_of
from diagnosis.estimation.least_squares import Fitter
from diagnosis.estimation.noise import HUBER, ORDER, ChannelNoise, Whitener, estimate, history
from diagnosis.estimation.splines import FINE_PIECES, free_shapes
from diagnosis.evidence.library import Library, build
from diagnosis.evidence.noise_estimation import Prepared
from diagnosis.evidence.score_test import Scorer
from diagnosis.observations.readings import (
    HAMPEL_LIMIT,
    HAMPEL_SAMPLES,
    MAD_TO_SIGMA,
    BoolArray,
    FloatArray,
)
from diagnosis.plants.contract import Model

RIDGE = 1e-9
LONGEST_MEMORY_S = 0.2
"""Correlation over a longer time is taken for a mismatch, not for noise."""
MOST_INFLATION = 4.0
ROUNDS = 3
MOST_SPIKES = 0.02
LONE = 7


def prepare_axis(model: Model, valid: BoolArray) -> Prepared:
    """Noise model, whitened library and scorer of one channel around the nominal machine."""
    library = build(model)
    residual = np.nan_to_num(model.readings.values) - model.predict(
        [n.term for n in model.nuisances]
    )
    left = residual - saturated(library, residual, valid)
    valid = without_spikes(left, valid)
    left = residual - saturated(library, residual, valid)
    fitter = Fitter(model, axis_noise(model, valid, left), model.nuisances)
    library.whiten(fitter)
    scorer = Scorer(library)
    scorer.inflation = _inflation(library, fitter, fitter.whiten(left))
    return Prepared(model, fitter, library, scorer, valid, free_shapes(model, FINE_PIECES), left)


def prepare_again(prepared: Prepared, residual: FloatArray, forced: bool) -> Prepared:
    """The same under the noise that an explanation leaves, `residual` (n, 1).

    forced: the axis is driven by effort; what is left is made by forces, which are slow.
    """
    model = prepared.model
    noise = (
        estimate(model.readings, prepared.valid, residual)
        if forced
        else axis_noise(model, prepared.valid, residual)
    )
    fitter = Fitter(model, noise, model.nuisances)
    prepared.library.whiten(fitter)
    scorer = Scorer(prepared.library)
    scorer.inflation = _inflation(prepared.library, fitter, fitter.whiten(residual))
    return Prepared(
        model, fitter, prepared.library, scorer, prepared.valid, prepared.fine, prepared.floor
    )


def without_spikes(residual: FloatArray, valid: BoolArray) -> BoolArray:
    """The valid mask less lone readings far off their neighbours.

    A machine mostly at rest makes every motion stand out, so a rule that finds many finds none.
    """
    rows = np.flatnonzero(valid[:, 0])
    values = residual[rows, 0]
    off = np.abs(values - median_filter(values, HAMPEL_SAMPLES, mode="nearest"))
    moved = off[off > 0.0]
    if not len(moved):
        return valid
    scale = MAD_TO_SIGMA * max(float(np.median(off)), float(np.median(moved)))
    far = off > HAMPEL_LIMIT * scale
    # A motion makes many neighbours stand out; a spike stands out alone or with one other.
    crowd = np.convolve(far, np.ones(LONE), mode="same")
    spikes = far & (crowd <= 2)
    kept = valid.copy()
    if spikes.mean() < MOST_SPIKES:
        kept[rows[spikes], 0] = False
    return kept


def saturated(library: Library, residual: FloatArray, valid: BoolArray) -> FloatArray:
    """What the whole library explains of a residual (n, 1) by plain least squares."""
    rows = valid[:, 0]
    columns = library.raw()[:, 0].T
    scale = np.maximum(np.linalg.norm(columns[rows], axis=0), 1e-30)
    inside = columns[rows] / scale.astype(np.float32)
    gram = np.asarray(inside.T @ inside, dtype=np.float64) + RIDGE * rows.sum() * np.eye(len(scale))
    along = np.asarray(inside.T @ residual[rows, 0], dtype=np.float64)
    weights = np.linalg.solve(gram, along) / scale
    explained: FloatArray = (columns @ weights)[:, None]
    return explained


def axis_noise(model: Model, valid: BoolArray, residual: FloatArray) -> Whitener:
    """Autoregression of the residual with a short memory; sigma is that of the innovations."""
    rows = history(model.readings, valid)[0]
    x = residual[:, 0]
    least = max(smallest_step(model.readings.values[:, 0]) / np.sqrt(12.0), 1e-12)
    table = x[rows]
    spread = max(float(np.sqrt(np.mean(table[:, 0] ** 2))), least)
    table = np.clip(table, -4 * spread, 4 * spread)
    gram = table.T @ table / len(table)
    ridge = 1e-9 * gram[0, 0] + 1e-300
    phi = np.linalg.solve(gram[1:, 1:] + ridge * np.eye(ORDER), gram[1:, 0])
    period_s = model.readings.period_s * float(np.median(np.diff(rows[:, 0])))
    phi = forgetful(phi, float(np.exp(-period_s / LONGEST_MEMORY_S)))
    innovation = table[:, 0] - table[:, 1:] @ phi
    sigma = max(_robust_sigma(innovation), least)
    noise = ChannelNoise(rows, phi, sigma, spread)
    whitener = Whitener((noise,), np.ones(len(rows))).weighed(residual)
    return Whitener(whitener.channels, whitener.weight * resting_weight(model)[rows[:, 0]])


def resting_weight(model: Model) -> FloatArray:
    """Square root of the weight of each reading, (n,): a rest counts once, however long it is.

    While nothing moves an encoder repeats one number with one rounding error.
    """
    values = model.readings.values[:, 0]
    driver = next(iter(model.drivers().values()))
    least = 1e-4 * float(np.ptp(driver)) + 1e-300
    still = np.zeros(len(values), dtype=bool)
    still[1:] = (np.diff(values) == 0.0) & (np.abs(np.diff(driver)) < least)
    still[model.readings.fresh] = False
    run = np.cumsum(~still)
    length = np.bincount(run)[run]
    weight: FloatArray = 1.0 / np.sqrt(length)
    return weight


def _robust_sigma(values: FloatArray) -> float:
    """Standard deviation with outliers pulled in; most values may be zero (a machine at rest)."""
    sigma = float(np.std(values))
    for _ in range(ROUNDS):
        sigma = float(np.sqrt(np.mean(np.clip(values, -HUBER * sigma, HUBER * sigma) ** 2)))
    return max(sigma, MAD_TO_SIGMA * float(np.median(np.abs(values))))


def forgetful(phi: FloatArray, most: float) -> FloatArray:
    """The same autoregression with every root pulled inside `most`."""
    roots = np.roots(np.concatenate([[1.0], -phi]))
    size = np.abs(roots)
    roots = np.where(size > most, roots * most / np.maximum(size, 1e-12), roots)
    return -np.real(np.poly(roots))[1:]


def smallest_step(values: FloatArray) -> float:
    """The step in which a reading comes, 0 when it does not come in steps."""
    known = values[np.isfinite(values)]
    if len(np.unique(known)) > 0.5 * len(known):
        return 0.0
    steps = np.diff(np.unique(known))
    steps = steps[steps > 1e-3 * np.median(steps)] if len(steps) else steps
    return float(np.quantile(steps, 0.05)) if len(steps) else 0.0


def _inflation(library: Library, fitter: Fitter, floor: FloatArray) -> FloatArray:
    """How much more each score scatters from block to block than white noise would."""
    blocks = blocks_of(fitter)
    inflation = np.ones(len(library.entries))
    for number, entry in enumerate(library.entries):
        column = library.white[:, entry.columns.start].astype(np.float64)
        sums = np.bincount(blocks, weights=column * floor)
        plain = float(column @ column)
        if plain > 0.0:
            inflation[number] = np.clip(float(sums @ sums) / plain, 1.0, MOST_INFLATION)
    return inflation
