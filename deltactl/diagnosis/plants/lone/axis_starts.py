"""Where fits of an axis start: sizes in which its prediction is not linear."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from deltactl.diagnosis.observations.readings import FloatArray, IntArray
from deltactl.diagnosis.plants.lone.axis_regressors import (
    WAVES,
    begins_of,
    usual_load,
    waves_of,
)
from deltactl.diagnosis.plants.lone.options import COMMANDED_AXIS
from deltactl.diagnosis.plants.lone.recorded_axis import RecordedAxis
from deltactl.diagnosis.plants.lone.waves import spectrum
from deltactl.recording.column_measures import TRAVEL


def starts(axis: RecordedAxis, key: str, residual: FloatArray) -> Sequence[dict[str, float]]:
    """Starts of the nonlinear sizes of a regressor, from the residual (n,) without it."""
    if key in ("play", "friction", "rubbing"):
        apart = float(np.ptp(np.quantile(residual[axis.rows], TRAVEL)))
        widest = COMMANDED_AXIS.widest_start * axis.span
        return [
            {
                **_widths(axis, key, min(share * apart, widest)),
                **{f"{key}.{name}": side for name in begins_of(axis)},
            }
            for share in COMMANDED_AXIS.play_starts
            for side in COMMANDED_AXIS.side_starts
        ]
    if key in WAVES:
        return [{f"{key}.waves": w} for w in _likely_waves(axis, residual, *waves_of(axis, key))]
    if key == "jump":
        return [{"jump.moment": _likely_jump(axis, residual)}]
    return []


def _widths(axis: RecordedAxis, key: str, width: float) -> dict[str, float]:
    """One width; of friction that grows with the load half of it by the load."""
    if key != "rubbing":
        return {f"{key}.width": width}
    return {f"{key}.width": 0.5 * width, f"{key}.grip": 0.5 * width / usual_load(axis)}


def _likely_waves(
    axis: RecordedAxis, residual: FloatArray, fewest: float, most: float
) -> list[float]:
    """Peaks of the residual's spectrum over the travel, slow changes and a line taken off.

    At the places that the prediction comes to: behind a lag or a play that is elsewhere on the way
    there than on the way back, by more than a fine wave.
    """
    at = (axis.observed - residual)[axis.rows] / axis.span
    step = 1.0 / COMMANDED_AXIS.steps_a_wave
    waves = step * np.arange(np.ceil(fewest / step), most / step)
    return _peaks(waves, spectrum(_less_slow(axis, residual, axis.rows, at), at, waves))


def _less_slow(
    axis: RecordedAxis, residual: FloatArray, rows: IntArray, at: FloatArray
) -> FloatArray:
    """The residual (m,) of some rows less a constant, a line over places (m,), slow changes."""
    left = residual[rows]
    time = (axis.t_s[rows] - axis.t_s[rows].mean()) / max(axis.readings.span_s, 1e-300)
    slow = np.stack([np.ones_like(at), at, time, time**2], axis=1)
    less: FloatArray = left - slow @ np.linalg.lstsq(slow, left, rcond=None)[0]
    return less


def _peaks(waves: FloatArray, power: FloatArray) -> list[float]:
    """The highest peaks of a spectrum, apart from each other."""
    best: list[float] = []
    for number in np.argsort(-power):
        if all(abs(waves[number] - other) > COMMANDED_AXIS.waves_apart for other in best):
            best.append(float(waves[number]))
        if len(best) == COMMANDED_AXIS.wave_starts:
            break
    return best


def _likely_jump(axis: RecordedAxis, residual: FloatArray) -> float:
    """Moment from which on the residual has another mean, by the largest likelihood ratio."""
    left = residual[axis.rows]
    left = left - left.mean()
    sums = np.cumsum(left)[:-1]
    count = np.arange(1, len(left))
    gain = sums**2 / (count * (len(left) - count))
    edge = max(COMMANDED_AXIS.jump_edge_rows, len(left) // COMMANDED_AXIS.jump_edge_share)
    gain[:edge] = gain[-edge:] = 0.0
    return float(axis.t_s[axis.rows[int(np.argmax(gain)) + 1]])
