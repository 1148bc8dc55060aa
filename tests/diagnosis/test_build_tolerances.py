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


def test_a_small_error_beside_a_fault_is_how_the_machine_was_built(
    delta: DeltaRobot, record: Record
) -> None:
    """However well it shows; by itself it is a finding."""
    home = EffectEntry(effect="home_offset", component="motor1", parameters={"angle": 3.2e-3})
    swelling = EffectEntry(
        effect="sensor_crosstalk", component="range_y", parameters={"curvature": 0.04}
    )
    alone = diagnose_recordings(delta, [record(home, seconds=45.0, seed=8)])
    assert [f.component for f in alone.findings] == ["motor1"]
    beside = diagnose_recordings(delta, [record(home, swelling, seconds=45.0, seed=8)])
    assert [f.effect for f in beside.findings] == ["sensor_crosstalk"]
    (allowed,) = [one for one in beside.allowed_for if one.component == "motor1"]
    assert allowed.effect == "home_offset"
    assert allowed.parameters["angle"].value == pytest.approx(3.2e-3, rel=0.25)
