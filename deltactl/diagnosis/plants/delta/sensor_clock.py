"""Three sensors of one row are read one after another: each range has a time of its own.

Our recordings carry these times as extra columns `t_x`, `t_y`, `t_z`; taken for the time of the
row, they would look like a latency of some milliseconds on each axis.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from deltactl.diagnosis.observations.options import OBSERVATIONS
from deltactl.models.robot import AXES, FloatArray
from deltactl.recording.tables.flat import FlatRecording


class OwnTimes:
    """When each range of one recording was measured, from the time of its row."""

    def __init__(self, recording: FlatRecording):
        self._t_s = recording.t_s
        self._late_s: dict[str, FloatArray] = {}
        for axis in AXES:
            own = recording.extra.get(f"t_{axis}")
            if own is None or own.dtype.kind not in "fiu":
                continue
            late_s = np.nan_to_num(own.astype(np.float64) - self._t_s)
            if np.any(late_s) and np.abs(late_s).max() < OBSERVATIONS.furthest_own_s:
                self._late_s[f"range_{axis}"] = late_s

    def shift(self, names: Sequence[str], predicted: FloatArray) -> FloatArray:
        """Predictions (n, channels) for the times of the rows, carried to each range's own time."""
        for column, name in enumerate(names):
            if name in self._late_s:
                own_s = self._t_s + self._late_s[name]
                predicted[:, column] = np.interp(own_s, self._t_s, predicted[:, column])
        return predicted
