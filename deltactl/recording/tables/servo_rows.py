"""The flat table of a servo's run: one row a sample of its loop, readings beside the nearest."""

from __future__ import annotations

import numpy as np

from deltactl.recording.reading.columns import FloatArray, Int64Array
from deltactl.recording.reading.run import Readings, Run
from deltactl.recording.tables.flat import AnyArray

_NS = 1e-9
STEMS = {
    "command": "reference_rad",
    "theta": "angle_rad",
    "current": "current_a",
    "disturbance": "disturbance_a",
}
"""Columns of the table and the fields of `deltactl.recording.run.Servo` they come from."""


def servo_rows(
    run: Run, fresh: dict[str, Readings]
) -> tuple[Int64Array, dict[str, FloatArray], dict[str, AnyArray]]:
    """Times [ns], columns of the contract, and columns beside it.

    `fresh` are the readings of each sensor without stale ones. A range stands in the row whose
    time is nearest to the reading's own, which is kept as `t_x, t_y, t_z`; other rows are empty.
    """
    rising = np.concatenate([[True], np.diff(run.servo.t_ns) > 0])
    t_ns = run.servo.t_ns[rising]
    columns = {
        f"{stem}_{motor + 1}": getattr(run.servo, field)[rising, motor]
        for stem, field in STEMS.items()
        for motor in range(3)
    }
    extra: dict[str, AnyArray] = {}
    for axis, samples in fresh.items():
        rows = _nearest(t_ns, samples.t_ns)
        columns[f"range_{axis}"] = _spread(len(t_ns), rows, samples.distance_m)
        columns[f"status_{axis}"] = _spread(len(t_ns), rows, samples.status.astype(np.float64))
        extra[f"t_{axis}"] = _spread(len(t_ns), rows, samples.t_ns * _NS)
    return t_ns, columns, extra


def _nearest(t_ns: Int64Array, at_ns: Int64Array) -> Int64Array:
    """The row nearest to each time."""
    right = np.clip(np.searchsorted(t_ns, at_ns), 1, max(1, len(t_ns) - 1))
    right = np.minimum(right, len(t_ns) - 1)
    left = np.maximum(right - 1, 0)
    return np.where(at_ns - t_ns[left] <= t_ns[right] - at_ns, left, right)


def _spread(length: int, rows: Int64Array, values: FloatArray) -> FloatArray:
    """A column with values in some rows and nothing in the others."""
    column = np.full(length, np.nan)
    column[rows] = values
    return column
