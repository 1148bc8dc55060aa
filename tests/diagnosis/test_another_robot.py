"""Which recordings belong to a robot file, whatever is wrong with the robot."""

from __future__ import annotations

import pytest

from diagnosis.another_robot import check_belongs
from foundation.errors import RecordingError
from models.robot import DeltaRobot, EffectEntry


@pytest.mark.parametrize("late_s", [0.2, 0.45])
def test_a_late_recording_belongs(delta: DeltaRobot, record, late_s: float) -> None:
    """So far behind, hardly a sample is where the commands say at that moment."""
    entry = EffectEntry(effect="sensor_latency", component="sensors", parameters={"time": late_s})
    check_belongs(delta, record(entry, seconds=40.0))


def test_one_late_motor_belongs(delta: DeltaRobot, record) -> None:
    entry = EffectEntry(
        effect="following_lag", component="motor2", parameters={"time": 0.05, "dead_time": 0.4}
    )
    check_belongs(delta, record(entry, seconds=40.0))


def test_longer_arms_are_another_robot(delta: DeltaRobot, record) -> None:
    recording = record(seconds=40.0)
    other = delta.model_copy(
        update={"geometry": delta.geometry.model_copy(update={"forearm_m": 0.6})}
    )
    with pytest.raises(RecordingError, match="forearm"):
        check_belongs(other, recording)
