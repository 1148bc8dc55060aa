"""What drawings of an answer need; no part of its JSON."""

from __future__ import annotations

from typing import Any

import numpy as np
from pydantic import Field

from deltactl.diagnosis.answer.finding import Record, Where

FloatArray = np.ndarray[Any, np.dtype[np.float64]]
BoolArray = np.ndarray[Any, np.dtype[np.bool_]]


def bare(covariate: str) -> str:
    """A covariate's name without its unit: 'theta_1 [rad]' -> 'theta_1'."""
    return _parted(covariate)[0]


def unit_of(covariate: str) -> str:
    """The unit in the name's brackets; empty where it has none."""
    return _parted(covariate)[1]


def _parted(covariate: str) -> tuple[str, str]:
    name = covariate.strip()
    at = max(name.rfind("["), name.rfind("("))
    if at < 0 or not name.endswith(("]", ")")):
        return name, ""
    return name[:at].strip(), name[at + 1 : -1]


class Channel(Record):
    """One observation channel for drawings; arrays of shape (n,), NaN where nothing is valid."""

    name: str
    unit: str
    observed: FloatArray
    before: FloatArray
    """Prediction of the robot file alone."""
    after: FloatArray
    """Prediction with all findings."""
    noise: float
    """Standard deviation of the readings' noise."""
    counted: FloatArray | None = None
    """How much each reading counts in the figures of the fit; None: all that are valid, alike."""


class Picture(Record):
    """What a drawing needs; not in the JSON."""

    t_s: FloatArray
    channels: list[Channel]
    covariates: dict[str, FloatArray] = Field(default_factory=dict)
    """Interpretable quantities over time to draw the model error against, name (with unit) ->
    (n,)."""
    shift_s: tuple[float, ...] = (0.0,)
    """By how much the times of each recording were shifted to follow each other in `t_s`."""

    rests: BoolArray | None = None
    """Where a single axis' command rests, shape (n,); None where its speed alone tells."""

    def shift_of(self, where: Where) -> float:
        """What to add to the times of a place that lies in one recording."""
        number = where.recordings[0] if where.recordings else 1
        return self.shift_s[number - 1] if number <= len(self.shift_s) else 0.0
