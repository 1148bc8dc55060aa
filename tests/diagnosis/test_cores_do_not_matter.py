"""The same recording gives the same answer, to the last digit, on one core and on two."""

from __future__ import annotations

from collections.abc import Callable
from contextvars import Context

import pytest

from deltactl.diagnosis.api import diagnose_recordings
from deltactl.diagnosis.estimation import side_by_side
from deltactl.diagnosis.estimation.side_by_side import alone
from deltactl.models.robot import DeltaRobot, EffectEntry
from deltactl.recording.tables.flat import FlatRecording

Record = Callable[..., FlatRecording]
CAUSES = (
    EffectEntry(effect="gear_ratio", component="motor2", parameters={"scale": 1.02}),
    EffectEntry(effect="sensor_offset", component="range_z", parameters={"offset": 0.006}),
)


@pytest.mark.study
def test_one_core_and_two_answer_alike(
    delta: DeltaRobot, record: Record, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(side_by_side, "_cores", lambda: 2)
    recording = record(*CAUSES, seconds=30.0)
    anew = Context()  # without the `alone` of all tests
    on_two = anew.run(diagnose_recordings, delta, [recording])
    with alone():
        on_one = diagnose_recordings(delta, [recording])
    assert len(on_two.findings) == len(CAUSES)
    assert on_two.to_json() == on_one.to_json()
