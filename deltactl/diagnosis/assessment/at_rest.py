"""What is left of an axis while its command stands, and while it moves.

In: a residual and which rest each row lies in. Out: an `AtRest`. An axis that moves while its
command stands is pulled by something, or creeps: no effect of its drive does that.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.ndimage import median_filter

from deltactl.diagnosis.answer.records import AtRest
from deltactl.diagnosis.assessment.options import ASSESSMENT
from deltactl.diagnosis.assessment.regression_holdout import rms
from deltactl.diagnosis.observations.readings import FloatArray, IntArray
from deltactl.foundation.scatter import MAD_TO_SIGMA


def at_rest(
    left: FloatArray, stays: IntArray, resolution: float, load_known: bool
) -> AtRest | None:
    """Of a residual (m,) in rests of which stays (m,) has the number, -1 in motion.

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
        left_m=rms(left[resting]),
        left_in_motion_m=rms(left[~resting]),
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
