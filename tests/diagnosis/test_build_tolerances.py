"""An error that every machine may have comes after a fault, however well it shows."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from deltactl.diagnosis.api import diagnose_recordings
from deltactl.models.robot import DeltaRobot, EffectEntry
from deltactl.recording.tables.flat import FlatRecording

pytestmark = pytest.mark.study

Record = Callable[..., FlatRecording]


def test_a_late_sensor_is_not_taken_for_the_usual_lateness(
    delta: DeltaRobot, record: Record
) -> None:
    late = EffectEntry(effect="sensor_latency", component="sensors", parameters={"time": 0.03})
    answer = diagnose_recordings(delta, [record(late, seconds=40.0)])
    assert [f.effect for f in answer.findings] == ["sensor_latency"]


def test_a_small_error_comes_after_a_fault(delta: DeltaRobot, record: Record) -> None:
    home = EffectEntry(effect="home_offset", component="motor1", parameters={"angle": 3.2e-3})
    swelling = EffectEntry(
        effect="sensor_crosstalk", component="range_y", parameters={"curvature": 0.002}
    )
    answer = diagnose_recordings(delta, [record(home, swelling, seconds=45.0, seed=8)])
    assert [f.effect for f in answer.findings] == ["sensor_crosstalk", "home_offset"]
    assert answer.findings[1].evidence.delta_chi2 > answer.findings[0].evidence.delta_chi2
