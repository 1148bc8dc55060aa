"""Would readings that come late explain what looks like lost steps?

Late readings trail behind by speed times lateness: the excess follows the rate at which ranges were
meant to change. Lost steps make it jump and stay. Both are fitted to the last seconds.
"""

from __future__ import annotations

import numpy as np

from deltactl.firmware_py.feedback.residuals import Residuals
from deltactl.foundation.clock import ns
from deltactl.models.robot import AXES, FloatArray

BELIEVABLE_S = (0.03, 0.5)
ONSETS_S = (0.3, 0.45, 0.7, 1.0, 1.5, 2.0)
"""Before now: when steps may have been lost."""
AS_WELL = 1.05
"""A sum of squares larger by this share is no worse: of some 400 readings chance makes it so."""


def late_s(rows: Residuals, now_ns: int) -> float:
    """By how much readings would have to be late; 0 where lost steps explain the rows better."""
    here = np.stack([rows.axis == axis for axis in range(len(AXES))], axis=1).astype(np.float64)
    late = np.column_stack([here, -rows.rate_mps])
    found, cost = _fit(late, rows.excess_m)
    since = (rows.t_ns >= now_ns - ns(onset) for onset in ONSETS_S)
    lost = min(
        _fit(np.hstack([here, rows.slope_m * after[:, np.newaxis]]), rows.excess_m)[1]
        for after in since
    )
    least_s, most_s = BELIEVABLE_S
    seconds = float(found[-1])
    return seconds if least_s <= seconds <= most_s and cost <= AS_WELL * lost else 0.0


def _fit(columns: FloatArray, seen_m: FloatArray) -> tuple[FloatArray, float]:
    """Coefficients, and the sum of squares that is left."""
    found = np.linalg.lstsq(columns, seen_m, rcond=1e-9)[0]
    return found, float(np.sum((seen_m - columns @ found) ** 2))
