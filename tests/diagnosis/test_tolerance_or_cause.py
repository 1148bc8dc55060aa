"""Errors that every machine may have are no findings beside a fault."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from deltactl.diagnosis.api import diagnose_recordings
from deltactl.models.robot import DeltaRobot, EffectEntry
from deltactl.recording.tables.flat import FlatRecording

Record = Callable[..., FlatRecording]
FAULT = EffectEntry(effect="sensor_crosstalk", component="range_y", parameters={"curvature": 0.04})


def _forearm(length_error_m: float) -> EffectEntry:
    size = {"length_error": length_error_m}
    return EffectEntry(effect="forearm_length", component="arm3", parameters=size)


@pytest.mark.study
@pytest.mark.parametrize(("length_error_m", "faults"), [(0.0007, 1), (0.004, 2)])
def test_only_what_is_out_of_tolerance_stands_beside_a_fault(
    delta: DeltaRobot, record: Record, length_error_m: float, faults: int
) -> None:
    answer = diagnose_recordings(delta, [record(FAULT, _forearm(length_error_m), seconds=30.0)])
    names = {(f.effect, f.component) for f in answer.findings}
    assert names == {("sensor_crosstalk", "range_y"), ("forearm_length", "arm3")} or faults == 1
    assert len(names) == faults
    assert ("sensor_crosstalk", "range_y") in names
    assert answer.loosely_built is (faults == 1)
    assert answer.fit.rms_before_m > 1.1 * answer.fit.rms_after_m
