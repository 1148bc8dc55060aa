"""What is left: how long it goes on, and how large it is where the machine rests."""

from __future__ import annotations

import math

import numpy as np
from scipy.ndimage import median_filter

from deltactl.diagnosis.answer.records import AtRest, Channel, Fit, Picture
from deltactl.diagnosis.assessment.options import ASSESSMENT
from deltactl.diagnosis.evidence.effective_size import root_mean_square
from deltactl.diagnosis.observations.readings import FloatArray, IntArray
from deltactl.foundation.scatter import MAD_TO_SIGMA


def with_persistence(fit: Fit, picture: Picture) -> Fit:
    """The figures with the correlation time of the residual, in the most correlated channel."""
    found = [one for channel in picture.channels if (one := _of(channel, picture.t_s)) is not None]
    if not found:
        return fit
    correlation, apart_s, lasts_s = max(found)
    left = {"left_apart_s": apart_s, "left_lasts_s": lasts_s}
    return fit.model_copy(update={"left_correlation": correlation, **left})


def _of(channel: Channel, t_s: FloatArray) -> tuple[float, float, float] | None:
    """Correlation of the residual from one reading to the next, the time between them, and after
    which it is below 1/e; None where readings are too few to tell.
    """
    left = channel.observed - channel.after
    valid = np.isfinite(left)
    left, t_s = left[valid], t_s[valid]
    if len(left) < ASSESSMENT.fewest_readings or not np.ptp(left) > 0.0:
        return None
    steps_s = np.diff(t_s)
    period_s = float(np.median(steps_s))
    apart = (steps_s <= 0.0) | (steps_s > ASSESSMENT.apart_periods * period_s)
    stretch = np.concatenate([[0], np.cumsum(apart)])
    period_s = float(np.mean(steps_s[~apart]))  # thinned rows are one or two samples apart
    left = left - left.mean()
    first = _correlation(left, stretch, 1)
    if first is None:
        return None
    lag = 1
    while (now := _correlation(left, stretch, lag)) is not None and now > math.exp(-1.0):
        lag += max(1, lag // 8)
    return first, period_s, lag * period_s


def _correlation(left: FloatArray, stretch: IntArray, lag: int) -> float | None:
    """Correlation of readings `lag` apart in one stretch; None where such pairs are too few."""
    near = stretch[lag:] == stretch[:-lag]
    if int(near.sum()) < ASSESSMENT.fewest_readings // 2:
        return None
    return float(np.mean((left[lag:] * left[:-lag])[near]) / np.mean(left**2))


def at_rest(
    left: FloatArray, stays: IntArray, resolution: float, load_known: bool
) -> AtRest | None:
    """Whether a residual (m,) repeats at rests; stays (m,) has the number of the rest, -1 in
    motion.

    resolution: smallest step of the reading. None where either kind has too few rows to tell.
    """
    resting = stays >= 0
    fewest = ASSESSMENT.fewest_at_rest
    if min(np.count_nonzero(resting), np.count_nonzero(~resting)) < fewest:
        return None
    rests = [left[stays == number] for number in np.unique(stays[resting])]
    rests = [rest[int(ASSESSMENT.settling_share * len(rest)) :] for rest in rests]
    rests = [rest for rest in rests if len(rest) >= fewest]
    ranges = _ranges(rests, resolution)
    return AtRest(
        left_m=root_mean_square(left[resting]),
        left_in_motion_m=root_mean_square(left[~resting]),
        rests=len(rests),
        moved=len(ranges),
        moved_by_m=float(np.max(ranges, initial=0.0)),
        load_known=load_known,
    )


def _ranges(rests: list[FloatArray], resolution: float) -> list[float]:
    """By how much the axis moved, in each rest in which it moved by more than readings scatter."""
    if not rests:
        return []
    steps = np.concatenate([np.diff(rest) for rest in rests])
    noise = MAD_TO_SIGMA * float(np.median(np.abs(steps))) / math.sqrt(2.0)
    hair = max(ASSESSMENT.moved_sigma * noise, ASSESSMENT.moved_steps * resolution)
    ranges = (float(np.ptp(median_filter(rest, 3, mode="mirror"))) for rest in rests)
    return [moved for moved in ranges if moved > hair]
