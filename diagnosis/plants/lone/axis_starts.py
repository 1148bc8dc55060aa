"""Where fits of an axis start: sizes in which its prediction is not linear."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from diagnosis.observations.readings import FloatArray
from diagnosis.plants.lone.axis_regressors import (
    FEWEST_WAVES,
    begins_of,
    highest_hz,
    most_waves,
    usual_load,
)
from diagnosis.plants.lone.recorded_axis import RecordedAxis

LAG_STARTS_S = (
    (0.0, 0.02), (0.0, 0.08), (0.03, 0.0), (0.1, 0.0), (0.06, 0.06), (0.25, 0.05), (0.06, 0.25),
)  # fmt: skip
"""Time constants and dead times to start from."""
WIDTHS = (0.05, 0.15, 0.4, 1.0)
"""Widths of play to start from, as shares of how far reading and prediction are apart."""
SIDES = (-0.7, 0.0, 0.7)
PERIODS = 3


def starts(axis: RecordedAxis, key: str, residual: FloatArray) -> Sequence[dict[str, float]]:
    """Where to start the nonlinear sizes of a regressor."""
    if key == "lag":
        return [{"lag.time": a, "lag.dead_time": b} for a, b in LAG_STARTS_S]
    if key in ("play", "friction", "rubbing"):
        apart = float(np.ptp(np.quantile(residual[axis.rows], [0.02, 0.98])))
        return [
            {
                **_widths(axis, key, min(share * apart, 0.5 * axis.span)),
                **{f"{key}.{name}": side for name in begins_of(axis)},
            }
            for share in WIDTHS
            for side in SIDES
        ]
    if key == "gear":
        return [{"gear.waves": w} for w in _likely_waves(axis, residual)]
    if key == "jump":
        return [{"jump.moment": _likely_jump(axis, residual)}]
    if key == "ringing":
        near = np.geomspace(0.6, 0.9 * highest_hz(axis), 7)
        return [{"ringing.frequency": float(f), "ringing.damping": 0.1} for f in near]
    return [{}]


def _widths(axis: RecordedAxis, key: str, width: float) -> dict[str, float]:
    """One width; of friction that grows with the load half of it by the load."""
    if key != "rubbing":
        return {f"{key}.width": width}
    return {f"{key}.width": 0.5 * width, f"{key}.grip": 0.5 * width / usual_load(axis)}


def _likely_waves(axis: RecordedAxis, residual: FloatArray) -> list[float]:
    """Peaks of the residual's spectrum over the travel, slow changes and a line taken off."""
    rows = axis.rows[:: max(1, len(axis.rows) // 800)]
    left, at = residual[rows], axis.commanded[rows] / axis.span
    time = (axis.t_s[rows] - axis.t_s[rows].mean()) / max(axis.readings.span_s, 1e-300)
    slow = np.stack([np.ones_like(at), at, time, time**2], axis=1)
    left = left - slow @ np.linalg.lstsq(slow, left, rcond=None)[0]
    waves = np.linspace(1.1 * FEWEST_WAVES, most_waves(axis), int(6 * most_waves(axis)))
    turns = np.exp(2j * np.pi * np.outer(at, waves))
    power = np.abs(left @ turns) ** 2
    best: list[float] = []
    for number in np.argsort(-power):
        if all(abs(waves[number] - other) > 0.6 for other in best):
            best.append(float(waves[number]))
        if len(best) == PERIODS:
            break
    return best


def _likely_jump(axis: RecordedAxis, residual: FloatArray) -> float:
    """Moment from which on the residual stands elsewhere, by the largest likelihood ratio."""
    left = residual[axis.rows]
    left = left - left.mean()
    sums = np.cumsum(left)[:-1]
    count = np.arange(1, len(left))
    gain = sums**2 / (count * (len(left) - count))
    edge = max(4, len(left) // 200)
    gain[:edge] = gain[-edge:] = 0.0
    return float(axis.t_s[axis.rows[int(np.argmax(gain)) + 1]])
