"""An error that repeats with the angle: of a gear, or of the encoder that reads it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from models.cosine_sine import cosine_and_sine
from models.effects.kind import Parameter, Values, scalar
from models.robot import FloatArray

PARAMETERS = (
    Parameter("amplitude", "rad", 0.0, 0.2, starts=(0.001,), typical=0.002),
    Parameter("period", "rad", 1e-3, 2.0 * np.pi, starts=(2.0 * np.pi,), step=1e-4, spread=1.0),
    Parameter("phase", "rad", -np.pi, np.pi, starts=(0.0,), default=0.0),
)


def add_periodic(angles_rad: FloatArray, index: int, values: Values) -> None:
    """Add amplitude * sin(2 pi angle / period + phase) to column `index` of (n, 3), in place."""
    angle = angles_rad[:, index]
    turns = 2.0 * np.pi * angle / scalar(values, "period")
    _, sine = cosine_and_sine(turns + scalar(values, "phase"))
    angles_rad[:, index] = angle + scalar(values, "amplitude") * sine


def size_in_words(values: Mapping[str, Any]) -> str:
    """Amplitude and period for the effect's sentence."""
    amplitude_deg, period_deg = np.degrees(values["amplitude"]), np.degrees(values["period"])
    return f"{amplitude_deg:.3f} degrees every {period_deg:.2f} degrees"
