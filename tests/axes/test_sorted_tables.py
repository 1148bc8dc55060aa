"""Tables of a range sensor that go from near to far: without times they may be sorted."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from deltactl.diagnosis.api import diagnose_recordings
from deltactl.diagnosis.report.page import report_html
from deltactl.models.robot import RangeSensor
from deltactl.recording.tables.flat import FlatRecording, from_columns
from tests.rigs.charts import charts_of

SENSOR = RangeSensor(kind="range_sensor", name="sonar")


def _counted(columns: dict[str, np.ndarray[Any, Any]]) -> FlatRecording:
    """As the reader makes a table without times."""
    return replace(from_columns(columns, "table"), timed=False)


def test_a_curved_error_in_a_sorted_table_is_foretold() -> None:
    """Left out whole, the far fifth of a curve would be worse guessed than with no model."""
    distance_m = np.repeat(np.linspace(0.02, 1.1, 50), 5)
    rng = np.random.default_rng(3)
    error_m = -0.045 * distance_m + 0.027 * distance_m**2 + 0.004 * np.sin(9.0 * distance_m)
    noise_m = 3e-4 * rng.standard_normal(len(distance_m))
    columns = {
        "t": np.arange(len(distance_m)) * 0.1,
        "distance": distance_m,
        "range": distance_m + error_m + noise_m,
    }
    fit = diagnose_recordings(SENSOR, [from_columns(columns, "table")]).fit
    assert fit.holdout_rms_after_m < 0.4 * fit.holdout_rms_before_m


def test_an_error_that_breaks_off_beyond_a_distance_is_no_noise() -> None:
    """The readings of a sensor at a ruler: some mm too far, and from 280 mm on far too near. The
    scale of a sensor is never so wrong; what it could not take stood in no shape and was "noise".
    """
    distance_m = np.concatenate([np.arange(0.03, 0.1, 0.005), np.arange(0.1, 0.305, 0.01)])
    rng = np.random.default_rng(5)
    error_m = 0.004 + 0.006 * np.sin(np.pi * np.clip(distance_m / 0.27, 0.0, 1.0) ** 1.5)
    error_m[distance_m > 0.275] = -0.018
    noise_m = 1e-3 * rng.standard_normal(len(distance_m))
    columns = {
        "t": np.arange(len(distance_m)) * 1.0,
        "distance": distance_m,
        "range": distance_m + error_m + noise_m,
    }
    answer = diagnose_recordings(SENSOR, [_counted(columns)])
    assert answer.findings[-1].depends_on == ["distance"]
    assert answer.verdict != "explained"
    assert answer.fit.rms_after_m < 3e-3


def test_the_report_of_a_table_without_times_is_drawn_over_the_distance() -> None:
    """A clock was invented, and the chart that matters was not there."""
    distance_m = np.linspace(0.05, 0.3, 40)
    noise_m = 1e-3 * np.random.default_rng(2).standard_normal(40)
    columns = {"t": np.arange(40.0), "distance": distance_m, "range": distance_m + 0.01 + noise_m}
    answer = diagnose_recordings(SENSOR, [_counted(columns)])
    drawn = charts_of(lambda: report_html(answer, SENSOR))
    (chart,) = drawn.values()
    assert "distance [mm]" in str(chart)
    assert "time [s]" not in str(chart)


@pytest.mark.study
def test_a_target_that_only_goes_away_cannot_tell_a_latency_from_an_offset() -> None:
    """At one speed both are one constant; a recording with times is no table."""
    t_s = np.arange(1200) / 20.0
    distance_m = 0.3 + 0.02 * t_s
    noise_m = 1e-3 * np.random.default_rng(7).standard_normal(len(t_s))
    late_m = distance_m - 0.1 * 0.02 + noise_m
    columns = {"t": t_s, "distance": distance_m, "range": late_m}
    (finding,) = diagnose_recordings(SENSOR, [from_columns(columns, "away")]).findings
    either = {finding.effect, *(one.effect for one in finding.alternatives)}
    assert {"sensor_latency", "sensor_offset"} <= either
