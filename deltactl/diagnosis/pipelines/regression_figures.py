"""Figures of a selection of regressors: model error, what is left, drawings."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from deltactl.diagnosis.answer.options import VERDICT
from deltactl.diagnosis.answer.records import AtRest, Channel, Fit, Picture
from deltactl.diagnosis.answer.verdict import Rest, seen
from deltactl.diagnosis.assessment.intervals import NORMAL_95
from deltactl.diagnosis.assessment.options import ASSESSMENT
from deltactl.diagnosis.assessment.persistence import at_rest
from deltactl.diagnosis.assessment.regression_holdout import Blocks, as_file_says, on_other_runs
from deltactl.diagnosis.assessment.significance import chance, charge
from deltactl.diagnosis.evidence.effective_size import TemperedNoise, spike_weights
from deltactl.diagnosis.evidence.explanation import Explanation
from deltactl.diagnosis.evidence.options import EVIDENCE
from deltactl.diagnosis.observations.readings import FloatArray, IntArray
from deltactl.diagnosis.pipelines.options import REGRESSION
from deltactl.diagnosis.plants.regression import RegressionPlant
from deltactl.diagnosis.selection.named_first import Selected
from deltactl.diagnosis.selection.options import SELECTION


def rest_of(selected: Selected) -> Rest:
    """What the tests say of the residual: what it may follow, and its size."""
    by_size = beyond_noise(selected)
    charged = charge(selected.plant, selected.noise, selected.best)
    by_shape = selected.plant.rest(selected.best, charged) or _by_shape(selected)
    if by_size.p >= by_shape.p:
        return by_shape
    if not seen(by_shape.p):
        return by_size
    return replace(by_size, depends_on=by_shape.depends_on, component=by_shape.component)


def beyond_noise(selected: Selected) -> Rest:
    """Whether more is left than the largest noise that the spectra of what was read allow.

    Single readings far off their neighbours are noise, and so is what effects of the robot file may
    leave, what happens between samples, and what few tables have digits for.
    """
    plant, rows, left = selected.plant, selected.noise.rows, selected.best.residual
    steady = left.copy()
    steady[rows] *= spike_weights(left[rows], plant.kinds[rows])
    bounds = plant.noise_bounds(steady)
    if bounds is None:
        return Rest(1.0)
    between = 0.0 if plant.unsampled is None else selected.noise.rms(plant.unsampled[rows])
    digits = EVIDENCE.digits * selected.noise.rms((plant.observed + plant.drawn_on)[rows])
    left_out = _left_by_file(selected) + between**2 + plant.asked_rounding**2 + digits**2
    size = math.sqrt(max(selected.noise.rms(steady[rows]) ** 2 - left_out, 0.0))
    p = bounds.chance(size)
    share = 1.0 - (bounds.largest(VERDICT.alarm) / size) ** 2 if seen(p) else 0.0
    return Rest(p, share=share * (size / rms_left(selected.best, selected.noise)) ** 2)


def _by_shape(selected: Selected) -> Rest:
    """By spline terms that are not out of the question."""
    free, best = selected.left_over, selected.best
    known = free(best.keys, [best])
    unknown = [
        r
        for r in selected.plant.regressors
        if r.left_over and r.key not in best.keys and selected.probability[r.key] > SELECTION.open
    ]
    if not unknown:
        return Rest(1.0)
    asked = [(r, free(best.keys | {r.key}, [known])) for r in unknown]
    charged = charge(selected.plant, free.noise, known)
    pairs = [(chance(selected, more, known, charged), r, more) for r, more in asked]
    p, regressor, more = min(pairs, key=lambda item: item[0])
    share = max(known.chi2 - more.chi2, 0.0) / max(known.chi2, 1e-12)
    return Rest(p, regressor.follows, "", share)


def fit_of(
    selected: Selected, others: Sequence[RegressionPlant], rest: Rest, blocks: Blocks
) -> Fit:
    """Figures of the fit; what neither a test nor its size tells from noise is the noise floor."""
    after_m = rms_left(selected.best, selected.noise)
    free_m = selected.left_over.noise.size
    before, after = blocks.before, blocks.after
    if others:
        before, after = on_other_runs(selected, others)
    floor_m = min(free_m, after_m) if seen(rest.p) else after_m / _above_noise(selected)
    within_m = _within(selected)
    return Fit(
        rms_before_m=rms_left(as_file_says(selected.plant, selected.empty), selected.noise),
        rms_after_m=after_m,
        noise_floor_m=floor_m,
        holdout_rms_before_m=before,
        holdout_rms_after_m=after,
        unit=selected.plant.unit,
        done_by_known_m=_done_by_known(selected),
        scatter_within_m=within_m,
        sensor_noise=within_m is not None and within_m > VERDICT.half_of_power * floor_m,
        at_rest=_at_rest(selected),
        holdout="run" if others else "blocks",
    )


def left_by_known(selected: Selected, fit: Fit, excused: bool) -> float:
    """How large what effects of the file may leave is, root mean square.

    excused: an explanation was found, and gained no more than those effects may leave: what is left
    is theirs then.
    """
    above = fit.rms_after_m**2 - fit.noise_floor_m**2 if excused else 0.0
    return math.sqrt(max(_left_by_file(selected), above))


def _left_by_file(selected: Selected) -> float:
    """Mean square of what effects of the robot file may leave."""
    rows = selected.noise.rows
    rms, known = selected.noise.rms, selected.plant.left_by_known
    return sum(share * rms(alone[rows]) ** 2 for share, alone in known)


def _done_by_known(selected: Selected) -> float:
    """How large what effects of the file do is, root mean square over the rows that count."""
    done = selected.plant.done_by_known
    return 0.0 if done is None else selected.noise.rms(done[selected.noise.rows])


def _at_rest(selected: Selected) -> AtRest | None:
    plant, rows = selected.plant, selected.noise.rows
    if not _follows_a_command(plant):
        return None
    step = plant.rounding * math.sqrt(12.0)
    loaded = "load" in plant.covariates
    return at_rest(selected.best.residual[rows], plant.stays[rows], step, loaded)


def _follows_a_command(plant: RegressionPlant) -> bool:
    """Whether its rests are those of a command."""
    return not plant.averages and plant.unit in ("m", "rad")


def _within(selected: Selected) -> float | None:
    """Scatter of readings around their mean at one place; None where they stay too little to tell.

    Of an axis, only rests that last: noise with a memory hardly changes within a short one. What
    rests to a step has no noise that could.
    """
    plant, rows = selected.plant, selected.noise.rows
    stay, left = _under_one_load(plant)[rows], selected.best.residual[rows]
    lasting = REGRESSION.memories_a_stay * selected.noise.tau
    if _stands_still(stay, plant.observed[rows]):
        lasting = 0.0
    _, place, counts = np.unique(stay, return_inverse=True, return_counts=True)
    if not plant.averages:
        lasts = counts >= max(lasting, ASSESSMENT.fewest_at_rest)
        kept = (stay >= 0) & lasts[place]
        stay, left = stay[kept], left[kept]
        _, place, counts = np.unique(stay, return_inverse=True, return_counts=True)
    spare = len(stay) - len(counts)
    fewest = REGRESSION.fewest_places if plant.averages else 1
    if len(counts) < fewest or spare < max(len(counts), REGRESSION.fewest_stays):
        return None
    means = np.bincount(place, weights=left) / counts
    scatter = float(np.sqrt(np.sum((left - means[place]) ** 2) / spare))
    return max(scatter, plant.rounding)


def _stands_still(stay: IntArray, read: FloatArray) -> bool:
    """Whether readings (m,) are one and the same in most rests that are no shorter than a few."""
    rests = [read[stay == number] for number in np.unique(stay[stay >= 0])]
    ranges = [np.ptp(rest) for rest in rests if len(rest) >= ASSESSMENT.fewest_at_rest]
    return bool(ranges) and float(np.median(ranges)) == 0.0


def _under_one_load(plant: RegressionPlant) -> IntArray:
    """Number (n,) of the stay at one place and under one load; -1 in motion."""
    stays, load = plant.stays, plant.covariates.get("load")
    if load is None:
        return stays
    steps = np.abs(np.diff(load, prepend=load[0])) > REGRESSION.same_load * float(np.ptp(load))
    begins = steps | (np.diff(stays, prepend=-2) != 0)
    return np.where(stays < 0, -1, np.cumsum(begins)).astype(np.intp)


def _above_noise(selected: Selected) -> float:
    """How many times larger than noise what is left is at least; 1 where it may be noise.

    Against what the fullest set leaves, which is known to as few readings as are independent.
    """
    noise, left = selected.left_over.noise, selected.best.residual[selected.noise.rows]
    weight = noise.scale * noise.sigma
    size = float(np.sqrt(np.average((left / noise.sigma) ** 2, weights=weight**2)))
    return max(size / (1.0 + NORMAL_95 / math.sqrt(2.0 * noise.effective)), 1.0)


def rms_left(explanation: Explanation, noise: TemperedNoise) -> float:
    """What an explanation leaves of the rows that count, root mean square."""
    return noise.rms(explanation.residual[noise.rows])


def picture_of(selected: Selected, plant: RegressionPlant) -> Picture:
    """Arrays for drawings."""
    on = plant.drawn_on
    counted, sampled = np.zeros(len(plant.t_s)), selected.noise.sampled
    counted[plant.rows] = 1.0 if sampled is None else sampled
    channel = Channel(
        name=plant.channel,
        unit=plant.unit,
        observed=np.where(counted > 0.0, plant.observed + on, np.nan),
        before=as_file_says(plant, selected.empty).predicted + on,
        after=selected.best.predicted + on,
        noise=float(np.median(selected.left_over.noise.sigma)),
        counted=counted,
    )
    whole = Picture(
        t_s=plant.t_s,
        channels=[channel],
        covariates=dict(plant.covariates),
        shift_s=plant.readings.shift_s,
        rests=plant.stays >= 0 if _follows_a_command(plant) else None,
    )
    return plant.drawn(whole)
