"""An unknown that depends on how its place was come to remembers; otherwise it does not."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from deltactl.diagnosis.answer.records import Finding
from deltactl.diagnosis.api import diagnose_recordings
from deltactl.models.robot import DeltaRobot
from deltactl.recording.tables.flat import FlatRecording

pytestmark = pytest.mark.study

PERIOD_M = 0.05
SIZE_M = 0.006


def unknown(delta: DeltaRobot, recording: FlatRecording) -> Finding:
    found = [f for f in diagnose_recordings(delta, [recording]).findings if f.effect == "unknown"]
    return max(found, key=lambda f: f.evidence.delta_chi2)


def with_error(recording: FlatRecording, error_m: np.ndarray) -> FlatRecording:
    columns = dict(recording.columns)
    columns["range_y"] = columns["range_y"] + error_m
    return FlatRecording(recording.t_s, columns, {}, "synthetic")


def stripes(distance_m: np.ndarray) -> np.ndarray:
    return SIZE_M * np.sin(2.0 * np.pi * distance_m / PERIOD_M)


@pytest.mark.parametrize("late_s", [0.0, 0.3], ids=["present", "past"])
def test_the_past_is_told_from_the_present(
    delta: DeltaRobot, record: Callable[..., FlatRecording], late_s: float
) -> None:
    clean = record(seconds=60.0)
    distance_m = clean.columns["range_y"]
    kernel = np.ones(9) / 9.0
    smooth_m = np.convolve(np.pad(distance_m, 4, mode="edge"), kernel, mode="valid")
    past_m = np.interp(clean.t_s - late_s, clean.t_s, smooth_m)
    error_m = stripes(smooth_m) + (stripes(past_m) if late_s else 0.0)
    finding = unknown(delta, with_error(clean, error_m))
    assert finding.component == "range_y"
    assert finding.has_memory is (late_s > 0.0)
