"""Errors that every machine may have, by themselves and beside a fault."""

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


def test_a_small_error_by_itself_is_a_finding(delta: DeltaRobot, record: Record) -> None:
    """Beside a fault it says how the machine was built (`test_tolerance_or_cause`)."""
    short = EffectEntry(
        effect="forearm_length", component="arm3", parameters={"length_error": 1e-3}
    )
    answer = diagnose_recordings(delta, [record(short, seconds=45.0, seed=8)])
    assert [f.component for f in answer.findings] == ["arm3"]
