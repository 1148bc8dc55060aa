"""Which recordings belong to a robot file, whatever is wrong with the robot."""

from __future__ import annotations

import numpy as np
import pytest

from deltactl.diagnosis.admission.admit import admit
from deltactl.foundation.errors import RecordingError
from deltactl.models.robot import DeltaRobot, EffectEntry
from deltactl.recording.tables.flat import FlatRecording


@pytest.mark.parametrize("late_s", [0.2, 0.45])
def test_a_late_recording_belongs(delta: DeltaRobot, record, late_s: float) -> None:
    """So far behind, hardly a sample is where the commands say at that moment."""
    entry = EffectEntry(effect="sensor_latency", component="sensors", parameters={"time": late_s})
    admit(delta, [record(entry, seconds=40.0)]).passed()


def test_one_late_motor_belongs(delta: DeltaRobot, record) -> None:
    entry = EffectEntry(
        effect="following_lag", component="motor2", parameters={"time": 0.05, "dead_time": 0.4}
    )
    admit(delta, [record(entry, seconds=40.0)]).passed()


@pytest.mark.study
def test_longer_arms_are_another_robot(delta: DeltaRobot, record) -> None:
    recording = record(seconds=40.0)
    other = delta.model_copy(
        update={"geometry": delta.geometry.model_copy(update={"forearm_m": 0.6})}
    )
    with pytest.raises(RecordingError, match="forearm"):
        admit(other, [recording]).passed()


@pytest.mark.parametrize(("broke_s", "told"), [(6.0, r"[56]\.\d"), (26.0, r"2[567]\.\d")])
def test_what_broke_on_the_way_is_said_with_its_moment(
    delta: DeltaRobot, record, broke_s: float, told: str
) -> None:
    """From then on the readings are those of no machine of the file: a rod came off."""
    whole, apart = record(seconds=40.0), record(seconds=40.0, seed=2)
    late = whole.t_s > broke_s
    columns = {
        name: np.where(late, apart.columns[name], values) if name.startswith("range") else values
        for name, values in whole.columns.items()
    }
    with pytest.raises(RecordingError, match=rf"up to {told} s recording and robot file agree"):
        admit(delta, [FlatRecording(whole.t_s, columns, {}, "broken")]).passed()


@pytest.mark.parametrize("lost_s", [4.0, 26.0])
@pytest.mark.parametrize("steps", [-600.0, 600.0])
def test_a_great_loss_of_steps_is_no_breakage(
    delta: DeltaRobot, record, steps: float, lost_s: float
) -> None:
    entry = EffectEntry(
        effect="lost_steps", component="motor2", parameters={"steps": steps, "time": lost_s}
    )
    admit(delta, [record(entry, seconds=40.0)]).passed()


def test_a_loss_that_no_motor_has_is_a_breakage(delta: DeltaRobot, record) -> None:
    """36 degrees: the shift of a joint describes it, and steps that were lost do not explain it."""
    entry = EffectEntry(
        effect="lost_steps", component="motor2", parameters={"steps": -1600.0, "time": 20.0}
    )
    with pytest.raises(RecordingError, match="has an arm flipped to its other side"):
        admit(delta, [record(entry, seconds=40.0)]).passed()
