"""Ranges of one row are compared at the times they were measured."""

from __future__ import annotations

import numpy as np

from deltactl.diagnosis.plants.delta.model import OwnTimes
from deltactl.recording.tables.flat import FlatRecording


def test_a_prediction_is_carried_to_each_sensors_own_time() -> None:
    t_s = np.arange(100) * 0.02
    recording = FlatRecording(t_s, {}, {"t_x": t_s - 0.005, "t_z": t_s})
    slope = np.stack([t_s, t_s, t_s], axis=1)
    shifted = OwnTimes(recording).shift(["range_x", "range_y", "theta_1"], slope.copy())
    np.testing.assert_allclose(shifted[1:, 0], t_s[1:] - 0.005)
    np.testing.assert_array_equal(shifted[:, 1:], slope[:, 1:])


def test_times_that_belong_to_no_row_are_not_used() -> None:
    t_s = np.arange(100) * 0.02
    recording = FlatRecording(t_s, {}, {"t_x": t_s + 1000.0, "t_y": np.array(["late"] * 100)})
    values = np.stack([t_s, t_s], axis=1)
    shifted = OwnTimes(recording).shift(["range_x", "range_y"], values.copy())
    np.testing.assert_array_equal(shifted, values)
