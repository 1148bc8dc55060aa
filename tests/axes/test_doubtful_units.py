"""What is asked of units before an answer is believed, and what of held-out data is said."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from deltactl.diagnosis.api import diagnose_recordings
from deltactl.diagnosis.report.screen import sentences
from deltactl.foundation.errors import RecordingError
from deltactl.models.robot import RangeSensor, ServoAxis
from deltactl.recording.foreign.mapping import load_mapping
from deltactl.recording.foreign.reading import read_mapped
from deltactl.recording.tables.flat import FlatRecording, from_columns

T_S = np.arange(0.0, 20.0, 0.02)
AXIS = ServoAxis(kind="servo_axis", name="a", motion="rotary")


def follows(scale: float = 1.0, wild: float = 0.0, t_s: np.ndarray = T_S) -> FlatRecording:
    noise = 1e-3 * np.random.default_rng(0).standard_normal(len(t_s))
    told = np.sin(T_S)
    seen = told + noise
    seen[400] += wild
    return from_columns({"t": t_s, "command": scale * told, "position": scale * seen}, "a.csv")


@pytest.mark.study
def test_one_wild_reading_is_no_doubt_of_the_unit() -> None:
    assert diagnose_recordings(AXIS, [follows(wild=150.0)]).doubts == []
    (doubt,) = diagnose_recordings(AXIS, [follows(scale=150.0)]).doubts
    assert "turns" in doubt


@pytest.mark.study
def test_a_unit_that_was_given_is_not_doubted(tmp_path: Path) -> None:
    """A winch turns as often as its log says."""
    angles = follows(scale=150.0).columns
    table = np.stack([T_S, angles["command"], angles["position"]], axis=1)
    path = tmp_path / "winch.csv"
    np.savetxt(path, table, delimiter=",", header="t,goal_rad,place", comments="")
    mapping = load_mapping(None, ["command=goal_rad", "position=place[rad]"])
    assert diagnose_recordings(AXIS, [read_mapped(path, mapping)]).doubts == []


@pytest.mark.parametrize(("factor", "asks"), [(1e-3, "was another unit given"), (1e3, "in ms")])
def test_times_in_another_unit_are_asked_for_whatever_was_recorded(
    factor: float, asks: str
) -> None:
    recording = follows(t_s=factor * T_S)
    effort = from_columns(
        {"t": recording.t_s, "position": np.sin(T_S), "effort": np.cos(T_S)}, "b.csv"
    )
    driven = ServoAxis(kind="servo_axis", name="b", motion="rotary", inertia=0.1, effort_gain=1.0)
    for robot, one in ((AXIS, recording), (driven, effort)):
        with pytest.raises(RecordingError, match="must be in seconds") as error:
            diagnose_recordings(robot, [one])
        assert asks in str(error.value)


def test_millimetres_read_as_metres_are_doubted_of_a_sensor() -> None:
    rng = np.random.default_rng(1)
    distance = np.repeat(rng.uniform(500.0, 5000.0, 20), 10)
    seen = distance + rng.standard_normal(len(distance))
    sensor = RangeSensor(kind="range_sensor", name="tag")
    for unit, doubted in ((1.0, True), (1e-3, False)):
        columns = {
            "t": np.arange(len(distance)) * 0.1, "distance": unit * distance, "range": unit * seen
        }  # fmt: skip
        answer = diagnose_recordings(sensor, [from_columns(columns, "tag.csv")])
        assert sentences(answer)[0].startswith("Settle this first: distance") == doubted


@pytest.mark.study
def test_of_held_out_data_that_tell_nothing_it_is_said_why() -> None:
    still = from_columns({"t": T_S, "command": 0.0 * T_S, "position": np.sin(T_S)}, "still.csv")
    short = FlatRecording(T_S[:12], {n: x[:12] for n, x in follows().columns.items()}, {}, "short")
    answer = diagnose_recordings(AXIS, [follows()], [still, short])
    assert answer.fit.holdout == "blocks"
    why, why_too = answer.not_held_out
    assert "the command never changes" in why
    assert "short" in why_too
    assert any(line.startswith("Held-out data left out: still.csv") for line in sentences(answer))
    answer = diagnose_recordings(AXIS, [follows()], [follows()])
    assert any("; on another run " in line for line in sentences(answer))
