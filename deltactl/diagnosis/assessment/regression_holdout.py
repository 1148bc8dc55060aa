"""Model error on data that were not fitted: other recordings, or blocks left out in turn.

Blocks take no part in the sizes that are held against them; which effects there are was chosen
with all of the recording, and the answer says so.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from deltactl.diagnosis.assessment.options import ASSESSMENT
from deltactl.diagnosis.evidence.effective_size import TemperedNoise, root_mean_square
from deltactl.diagnosis.evidence.explanation import Explanation
from deltactl.diagnosis.evidence.laplace import Laplace, tolerated
from deltactl.diagnosis.observations.readings import FloatArray, IntArray
from deltactl.diagnosis.plants.regression import RegressionPlant
from deltactl.diagnosis.plants.regressor import Sizes
from deltactl.diagnosis.plants.spline_terms import carried_over
from deltactl.diagnosis.selection.named_first import Selected, named_sizes

LASTING = ("jump", "drift", "unknown time")
"""Regressors that belong to one moment or course of time and do not come back."""


@dataclass(frozen=True, slots=True, eq=False)
class Blocks:
    """RMS before and after on blocks left out, and the fits without each of them."""

    before: float
    after: float
    fits: list[Explanation]


def as_file_says(plant: RegressionPlant, explanation: Explanation) -> Explanation:
    """An explanation with what the file holds the machine to as the file has it: how far a machine
    is from its file must not hide in what is fitted in every set.
    """
    if not len(plant.held):
        return explanation
    sizes = explanation.linear[""].copy()
    sizes[plant.held] = 0.0
    ((values, _), *parts) = explanation.parts
    return replace(explanation, parts=((values, sizes), *parts))


def on_other_runs(selected: Selected, others: Sequence[RegressionPlant]) -> tuple[float, float]:
    """RMS before and after over all rows of other recordings, nothing refitted but what is free.

    Where in its play a machine is at first differs between recordings: that is read off each.
    """
    before, after, sampled = [], [], []
    for other in others:
        other.adopt(selected.plant)
        empty = other.base(frozenset(), {})
        before.append(_less_free(other, other.observed - empty))
        after.append(_left_of(selected, other))
        sampled.append(_sampled(selected.noise, other))
    weights = np.concatenate(sampled)
    left = (np.concatenate(before), np.concatenate(after))
    return root_mean_square(left[0], weights), root_mean_square(left[1], weights)


def _sampled(noise: TemperedNoise, other: RegressionPlant) -> FloatArray:
    """Share of the variance of another recording's rows (m,) that does not lie between samples."""
    if noise.sampled is None or other.unsampled is None:
        return other.counts[other.rows]
    own = float(np.mean(noise.sigma**2 * noise.sampled))
    return own / (own + other.unsampled[other.rows] ** 2)


def _left_of(selected: Selected, other: RegressionPlant) -> FloatArray:
    """What the sizes of one recording leave of another, on the rows of that which count."""
    sizes = {**selected.best.sizes, **dict.fromkeys(other.begins(selected.best.keys), 0.0)}

    def left(tried: Sizes) -> FloatArray:
        return _less_free(other, other.observed - _predicted(selected, other, tried))

    for name in other.begins(selected.best.keys):
        places = np.linspace(-1.0, 1.0, ASSESSMENT.places_to_begin)
        sizes = min(
            ({**sizes, name: float(place)} for place in sorted(places, key=abs)),
            key=lambda tried: root_mean_square(left(tried)),
        )
    return left(sizes)


def _predicted(selected: Selected, other: RegressionPlant, sizes: Sizes) -> FloatArray:
    """What the sizes of one recording say of another, (n,)."""
    best = selected.best
    keys = frozenset(k for k in best.keys if k not in LASTING)
    base = other.base(keys, sizes)
    held = other.held
    predicted = base + other.free().values[:, held] @ best.linear[""][held]
    for key in sorted(keys):
        if key.startswith("unknown "):
            predicted = predicted + _carried(selected, other, key)
            continue
        columns = other.columns(key, base, sizes)
        shapes = columns.values
        if columns.lasts and shapes.shape[1]:
            # Constants of the other recordings one by one say nothing of this one.
            predicted = predicted + shapes @ best.linear[key][: shapes.shape[1]]
    return predicted


def _carried(selected: Selected, other: RegressionPlant, key: str) -> FloatArray:
    """An unknown of one recording where another was."""
    at = other.followed(key)
    found = np.zeros(len(at))
    acts = np.isfinite(at)
    found[acts] = over_what_it_follows(selected, key, at[acts])
    return found


def over_what_it_follows(selected: Selected, key: str, at: FloatArray) -> FloatArray:
    """An unknown as a function (m,) of its covariate alone, at values (m,) of that."""
    plant, best = selected.plant, selected.best
    shapes = plant.columns(key, plant.base(best.keys, best.sizes), best.sizes).values
    shape, known = (shapes @ best.linear[key])[plant.rows], plant.followed(key)[plant.rows]
    there = np.isfinite(known)
    pieces = max(plant.detail(key), ASSESSMENT.carried_pieces)
    return carried_over(shape[there], known[there], pieces, at)


def _less_free(plant: RegressionPlant, left: FloatArray) -> FloatArray:
    """What is left on the rows that count, once what is free there is fitted."""
    from scipy.optimize import lsq_linear  # takes 0.1 s to import

    free, chosen = plant.free(), left[plant.rows]
    fitted = np.setdiff1d(np.arange(len(free.spread)), plant.held)
    if not len(fitted):
        return chosen
    most = (tolerated(plant) * free.spread)[fitted]
    shapes = free.values[np.ix_(plant.rows, fitted)]
    remaining: FloatArray = chosen - shapes @ lsq_linear(shapes, chosen, (-most, most)).x
    return remaining


def on_blocks(selected: Selected) -> Blocks:
    """Each block of rows against sizes that were fitted on the others."""
    plant, noise, best = selected.plant, selected.noise, selected.best
    number = _folds(plant, noise.rows)
    before = np.zeros(len(noise.rows))
    after = np.zeros(len(noise.rows))
    fits = []
    for block in range(ASSESSMENT.folds):
        held = number == block
        scale = np.where(held, 0.0, noise.scale)
        partial = Laplace(plant, replace(noise, scale=scale), selected.evidence)
        for keys, into in ((best.keys - best.found, before), (best.keys, after)):
            fit = partial(keys) if into is after else as_file_says(plant, partial(keys))
            into[held] = fit.residual[noise.rows][held]
        fits.append(partial(best.keys))
    return Blocks(noise.rms(before), noise.rms(after), fits)


def _folds(plant: RegressionPlant, rows: IntArray) -> IntArray:
    """Number (m,) of the block that each row is left out with: a fifth of the time, all channels.

    Of a table sorted by distance each fifth would lie beyond all others, or leave a gap that has to
    be guessed; there each block is several short stretches, spread over the range.
    """
    order = np.argsort(np.argsort(plant.t_s[rows], kind="stable"))
    along = plant.covariates.get("distance")
    if along is not None:
        steps = np.diff(along[rows])
        if np.all(steps >= 0.0) or np.all(steps <= 0.0):
            stretches: IntArray = order * ASSESSMENT.blocks // len(rows)
            return stretches % ASSESSMENT.folds
    return order * ASSESSMENT.folds // len(rows)


def beyond_noise(best: Explanation, blocks: Blocks) -> dict[str, float]:
    """Standard deviation that each size has beyond its noise, by the jackknife over blocks.

    What a model gets wrong is not the same in all parts of a motion (Shao and Tu 1995, The
    Jackknife and Bootstrap, section 2): a size that moves with the part is known no better.
    """
    each = [named_sizes(fit) for fit in blocks.fits]
    covariance = scaled_covariance(best)
    found = {}
    for row, name in enumerate(best.names):
        sizes = np.array([one[name] for one in each])
        jackknife = float((len(sizes) - 1) * np.var(sizes))
        noise = float(covariance[row, row])
        if jackknife > ASSESSMENT.moves * noise:
            found[name] = float(np.sqrt(jackknife - noise))
    return found


def scaled_covariance(explanation: Explanation, any_size: Collection[str] = ()) -> FloatArray:
    """Covariance (p, p) of all sizes in SI units; the likelihood is tempered.

    any_size: regressors whose sizes may be anything, where those of the others are as usual.
    """
    usual = [float(name.partition(".")[0] not in any_size) for name in explanation.names]
    bread = np.linalg.inv(np.diag(usual) + explanation.gram)
    widened: FloatArray = bread * np.outer(explanation.spreads, explanation.spreads)
    return widened
