"""What a perfect instrument would have seen of the simulated robot."""

from __future__ import annotations

from typing import NamedTuple

from deltactl.models.robot import FloatArray


class Outputs(NamedTuple):
    """Samples of one call."""

    theta: FloatArray
    """True arm angles [rad], shape (n, 3)."""
    position: FloatArray
    """Platform position [m], shape (n, 3); NaN where the linkage cannot be assembled."""
    ranges: FloatArray
    """What the three ranging sensors report [m], shape (n, 3)."""
    measured: FloatArray
    """What angle encoders on the arms report [rad], shape (n, 3)."""
