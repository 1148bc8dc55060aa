"""Effort that pushes the wrong way: a sign in a column, not physics."""

from __future__ import annotations

import numpy as np

from diagnosis.observations.readings import BoolArray, FloatArray
from foundation.errors import RecordingError

AGAINST = -0.3
"""Share of the force that the acceleration must answer with, if the sign is right: about 1."""
SURE = 6.0
"""Standard errors from nothing before a sign is called wrong."""
NEIGHBOURS = 20
"""Readings that count as one: efforts and smoothed accelerations are correlated in time."""


def refuse_wrong_sign(
    t_s: FloatArray, fresh: BoolArray, velocity: FloatArray, force: FloatArray,
    inertia: float, source: str,
) -> None:  # fmt: skip
    """Acceleration against the force, friction allowed for; all arrays (n,).

    Regression of inertia x acceleration on force, speed, direction and a constant. Raises
    RecordingError when the axis accelerates against the force.
    """
    pushed = inertia * np.gradient(velocity, t_s)
    # Differences across a gap are no accelerations.
    good = np.isfinite(pushed) & np.isfinite(force) & ~(fresh | np.roll(fresh, -1))
    columns = np.stack([force, velocity, np.sign(velocity), np.ones_like(force)], axis=1)[good]
    if len(columns) < 5 * NEIGHBOURS:
        return
    scale = np.maximum(np.abs(columns).max(axis=0), 1e-30)
    share, *_ = np.linalg.lstsq(columns / scale, pushed[good], rcond=1e-10)
    left = pushed[good] - columns / scale @ share
    inverse = np.linalg.pinv((columns / scale).T @ (columns / scale), hermitian=True)
    error = np.sqrt(inverse[0, 0] * np.mean(left**2) * NEIGHBOURS)
    if share[0] / scale[0] < AGAINST and share[0] < -SURE * error:
        raise RecordingError(
            f"{source}: the axis accelerates against its effort ({share[0] / scale[0]:.2f} times "
            "the force the robot file gives); is the sign of effort, of position or of effort_gain "
            "wrong?"
        )
