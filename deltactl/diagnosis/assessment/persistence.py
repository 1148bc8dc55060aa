"""How long what an explanation leaves goes on: the noise of a sensor is new with each reading."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from deltactl.diagnosis.answer.records import Channel, Picture
from deltactl.diagnosis.assessment.options import ASSESSMENT
from deltactl.diagnosis.observations.readings import FloatArray, IntArray


class Persistence(NamedTuple):
    """Of what is left: its correlation from one reading to the next, and for how long it lasts."""

    correlation: float
    apart_s: float
    """Time between those readings."""
    lasts_s: float
    """Time after which the correlation is below 1/e."""


def persistence(picture: Picture) -> Persistence | None:
    """Of the channel in which it is strongest; None where readings are too few to tell."""
    found = [one for channel in picture.channels if (one := _of(channel, picture.t_s)) is not None]
    return max(found, default=None)


def _of(channel: Channel, t_s: FloatArray) -> Persistence | None:
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
    return Persistence(first, period_s, lag * period_s)


def _correlation(left: FloatArray, stretch: IntArray, lag: int) -> float | None:
    """Of readings `lag` apart in one stretch; None where such pairs are too few."""
    near = stretch[lag:] == stretch[:-lag]
    if int(near.sum()) < ASSESSMENT.fewest_readings // 2:
        return None
    return float(np.mean((left[lag:] * left[:-lag])[near]) / np.mean(left**2))
