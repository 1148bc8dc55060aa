"""Recordings from which nothing can be told give one clear line."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from deltactl.diagnosis.admission.admit import admit
from deltactl.diagnosis.api import diagnose, diagnose_recordings
from deltactl.foundation.errors import DeltactlError, RecordingError
from deltactl.models.robot import DeltaRobot
from deltactl.recording.tables.flat import FlatRecording

Record = Callable[..., FlatRecording]
Change = Callable[[dict[str, np.ndarray]], None]


def _all_invalid(columns: dict[str, np.ndarray]) -> None:
    for axis in "xyz":
        columns[f"status_{axis}"] = np.full(len(columns["steps_1"]), 4.0)


def _constant(columns: dict[str, np.ndarray]) -> None:
    columns["range_y"][:] = 0.6


def _millimetres(columns: dict[str, np.ndarray]) -> None:
    for axis in "xyz":
        columns[f"range_{axis}"] *= 1000.0


def _still(columns: dict[str, np.ndarray]) -> None:
    for motor in (1, 2, 3):
        columns[f"steps_{motor}"][:] = 1000.0


def _no_commands(columns: dict[str, np.ndarray]) -> None:
    for motor in (1, 2, 3):
        del columns[f"steps_{motor}"]


def _nothing_seen(columns: dict[str, np.ndarray]) -> None:
    for axis in "xyz":
        del columns[f"range_{axis}"]


def _radians_as_steps(columns: dict[str, np.ndarray]) -> None:
    for motor in (1, 2, 3):
        columns[f"steps_{motor}"] *= 1000.0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (_all_invalid, "valid readings"),
        (_constant, "never changes"),
        (_millimetres, "must be in m"),
        (_still, "nothing moves"),
        (_no_commands, "steps_1..3"),
        (_nothing_seen, "nothing observed"),
        (_radians_as_steps, "steps_1 is .* the arm would be at"),
    ],
)
def test_one_clear_line(delta: DeltaRobot, record: Record, change: Change, words: str) -> None:
    recording = record(seconds=20.0)
    change(recording.columns)
    with pytest.raises(RecordingError, match=words) as caught:
        diagnose_recordings(delta, [recording])
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("rows", [1, 10])
def test_too_short(delta: DeltaRobot, record: Record, rows: int) -> None:
    whole = record(seconds=20.0)
    short = FlatRecording(
        whole.t_s[:rows], {name: x[:rows] for name, x in whole.columns.items()}, {}, "short"
    )
    with pytest.raises(RecordingError, match="at least"):
        diagnose_recordings(delta, [short])


def test_time_in_milliseconds(delta: DeltaRobot, record: Record) -> None:
    whole = record(seconds=20.0)
    slow = FlatRecording(whole.t_s * 1000.0, whole.columns, {}, "slow")
    with pytest.raises(RecordingError, match="seconds"):
        diagnose_recordings(delta, [slow])


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"upper_arm_m": 0.2, "forearm_m": 0.7}, "what comes nearest"),
        ({"forearm_m": 0.55}, "what comes nearest"),
        ({"azimuth_deg": (0.0, 240.0, 120.0)}, "no lengths"),
    ],
)
def test_another_robots_file(
    delta: DeltaRobot, record: Record, changes: dict[str, object], words: str
) -> None:
    geometry = delta.geometry.model_copy(update=changes)
    other = delta.model_copy(update={"geometry": geometry})
    with pytest.raises(RecordingError, match=f"do not belong together.*{words}") as caught:
        diagnose_recordings(other, [record(seconds=60.0)])
    assert "\n" not in str(caught.value)


@pytest.mark.study
def test_another_gear(delta: DeltaRobot, record: Record) -> None:
    assert delta.drive is not None
    drive = delta.drive.model_copy(update={"gear_ratio": 12.0})
    with pytest.raises(RecordingError, match="arms turning"):
        diagnose_recordings(delta.model_copy(update={"drive": drive}), [record(seconds=60.0)])


@pytest.mark.parametrize("home_deg", [(0.0, 0.0, 0.0), (3.0, -4.0, 8.0)])
def test_a_machine_that_something_stops_is_not_another(
    delta: DeltaRobot, record: Record, home_deg: tuple[float, float, float]
) -> None:
    """Half of the time it stands on something and slides about, and its homes may be wrong too."""
    recording = record(seconds=60.0)
    columns = recording.columns
    low = columns["range_z"] < np.median(columns["range_z"])
    columns["range_z"][low] = np.median(columns["range_z"])
    slid = 0.05 * np.cos(0.3 * recording.t_s)
    columns["range_x"][low] += slid[low]
    geometry = delta.geometry.model_copy(update={"home_offset_deg": home_deg})
    admit(delta.model_copy(update={"geometry": geometry}), [recording]).passed()


def test_empty_and_missing_files(tmp_path: Path) -> None:
    robot = tmp_path / "robot.yaml"
    robot.write_text("kind: range_sensor\nname: s\n")
    empty = tmp_path / "empty.csv"
    empty.write_text("")
    for path in (empty, tmp_path / "absent.csv"):
        with pytest.raises(DeltactlError) as caught:
            diagnose([path], robot)
        assert "\n" not in str(caught.value)
