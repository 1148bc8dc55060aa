"""An error that repeats with the angle: of a gear, or of the encoder that reads it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from deltactl.models.cosine_sine import cosine_and_sine
from deltactl.models.effects.fit import Coordinate, Fit, Shape
from deltactl.models.effects.kind import Parameter, Values, scalar
from deltactl.models.robot import FloatArray

PARAMETERS = (
    Parameter("amplitude", "rad", 0.0, 0.2, starts=(0.001,), typical=0.002),
    Parameter("period", "rad", 1e-3, 2.0 * np.pi, starts=(2.0 * np.pi,), step=1e-4, spread=1.0),
    Parameter("phase", "rad", -np.pi, np.pi, starts=(0.0,), default=0.0),
)


PERIODIC = Fit(
    coordinates=(
        Coordinate("amplitude", "sine", step=2e-4, low=-0.2, high=0.2),
        Coordinate("amplitude", "cosine", step=2e-4, low=-0.2, high=0.2),
        Coordinate("period", "log", step=1e-3, low=np.log(1e-3), high=np.log(2.0 * np.pi)),
    ),
    # Errors per turn of the arm that a gear or coupling may have.
    shapes=tuple(
        Shape((0.0, 0.0, float(np.log(2.0 * np.pi / n))), (0, 1), 2e-4)
        for n in (1, 2, 3, 4, 5, 6, 8, 10, 12, 15, 16, 20, 25, 30, 40, 50)
    ),
)
SECOND = (
    Parameter("amplitude_2", "rad", 0.0, 0.2, starts=(0.0005,), typical=0.001, default=0.0),
    Parameter("phase_2", "rad", -np.pi, np.pi, starts=(0.0,), default=0.0),
)
"""Of a lone axis: the second harmonic, which a gear's error has beside the first."""


def add_periodic(angles_rad: FloatArray, index: int, values: Values) -> None:
    """Add amplitude * sin(2 pi angle / period + phase) to column `index` of (n, 3), in place, and
    what there is of the second harmonic.
    """
    angle = angles_rad[:, index]
    turns = 2.0 * np.pi * angle / scalar(values, "period")
    _, sine = cosine_and_sine(turns + scalar(values, "phase"))
    angles_rad[:, index] = angle + scalar(values, "amplitude") * sine
    if "amplitude_2" in values:
        _, second = cosine_and_sine(2.0 * turns + scalar(values, "phase_2"))
        angles_rad[:, index] += scalar(values, "amplitude_2") * second


def size_in_words(values: Mapping[str, Any]) -> str:
    """Amplitude and period for the effect's sentence."""
    amplitude_deg, period_deg = np.degrees(values["amplitude"]), np.degrees(values["period"])
    return f"{amplitude_deg:.3f} degrees every {period_deg:.2f} degrees"
