"""A simulated run as a servo robot records it: means over 2 ms of what the loop saw."""

from __future__ import annotations

import numpy as np

from deltactl.models.robot import FloatArray
from deltactl.models.servo_drive import ServoDrive
from deltactl.recording.tables.flat import FlatRecording
from deltactl.reproduction.uzunovic_2013.control_loop import Run


def recorded(ran: Run, drive: ServoDrive, source: str = "") -> FlatRecording:
    """Columns t, command_i, theta_i, current_i, disturbance_i, from the tick control came on."""
    ticks = max(1, drive.loop_rate_hz // drive.record_rate_hz)
    whole = (len(ran.t_s) - ran.on) // ticks * ticks
    rows = slice(ran.on, ran.on + whole)

    def mean(values: FloatArray) -> FloatArray:
        means: FloatArray = values[rows].reshape(-1, ticks, *values.shape[1:]).mean(axis=1)
        return means

    columns = {
        f"{stem}_{joint + 1}": mean(values)[:, joint]
        for stem, values in (
            ("command", ran.reference_rad),
            ("theta", ran.measured_rad),
            ("current", ran.current_a),
            ("disturbance", ran.disturbance_a),
        )
        for joint in range(3)
    }
    return FlatRecording(np.asarray(mean(ran.t_s)), columns, {}, source)
