"""A small recorded run with errors that are known, made to order."""

from __future__ import annotations

import enum
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from deltactl.models.linkage import Linkage, inverse
from deltactl.recording.format.configuration import RunConfiguration
from deltactl.recording.reading.reader import read_run
from deltactl.recording.reading.run import Run
from deltactl.recording.writing.writer import RunRecorder

MS = 1_000_000
ROUNDS = 100
ON_PATH = range(20, 80)

ROBOT = """
kind: delta
name: zhao-2023
geometry: {base_radius_m: 0.325, platform_radius_m: 0.075, upper_arm_m: 0.25, forearm_m: 0.5}
drive: {microsteps_per_rev: 1600, gear_ratio: 10}
sensors:
  x: {offset_m: 0.60, axis: [1, 0, 0]}
  y: {offset_m: 0.60, axis: [0, 1, 0]}
  z: {offset_m: 0.90, axis: [0, 0, 1]}
"""
LINKAGE = Linkage(
    radius_m=np.full(3, 0.25),
    upper_arm_m=np.full(3, 0.25),
    forearm_m=np.full(3, 0.5),
    azimuth_rad=np.deg2rad([0.0, 120.0, 240.0]),
    home_offset_rad=np.zeros(3),
)
STEPS_PER_RAD = 16000 / (2 * np.pi)


class Gate(enum.Enum):
    """As in drivers."""

    GOOD = "good"
    SIGNAL = "signal"


@dataclass(frozen=True)
class Sample:
    """A reading, as drivers give it."""

    axis: str
    t_ns: int
    distance_m: float
    stream_count: int
    gate: Gate = Gate.GOOD
    status: int = 0
    raw_status: int = 9
    signal_mcps: float = 10.0
    ambient_mcps: float = 0.1
    sigma_m: float = 0.002


@dataclass
class Drawn:
    """What is to be recorded. Errors in m, added on the path; ten times as large off it."""

    robot: str = ROBOT
    truth_error_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    range_error_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    axes: Any = None
    stagger_ms: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """How long after the round's start each sensor is read."""
    weak: frozenset[tuple[str, int]] = frozenset()
    """(axis, round) of readings whose signal was too weak."""
    silent: frozenset[tuple[str, int]] = frozenset()
    with_truth: bool = True
    with_readings: bool = True
    events: tuple[tuple[int, str], ...] = ((ON_PATH[0], "path_start"), (ON_PATH[-1], "path_end"))
    closed: bool = True


def target(number: float) -> np.ndarray[Any, np.dtype[np.float64]]:
    """A level quarter circle."""
    angle = number / ROUNDS * np.pi / 2
    return np.array([0.1 * np.cos(angle), 0.1 * np.sin(angle), -0.45])


@pytest.fixture
def recorded_run(tmp_path: Path) -> Callable[..., Run]:
    """Records a drawn given by its changes, and reads it back."""

    def make(**changes: Any) -> Run:
        drawn = Drawn(**changes)
        path = tmp_path / "drawn.mcap"
        configuration = RunConfiguration(
            *(drawn.robot, "name: arc\n", "zhao-2023", "arc", "0.1.0"),
            start_epoch_ns=1_700_000_000 * 1000 * MS,
        )
        recorder = RunRecorder(path, configuration)
        recorder.settings(0, 0.006)
        for number, kind in drawn.events:
            recorder.event(number * 20 * MS, kind, kind)
        for number in range(ROUNDS):
            _record(recorder, drawn, number)
        assert recorder.flush()
        if drawn.closed:
            recorder.close()
        run = read_run(path)
        recorder.close()
        return run

    return make


def _record(recorder: RunRecorder, drawn: Drawn, number: int) -> None:
    now_ns = number * 20 * MS
    position_m = target(number)
    counts = np.rint(inverse(LINKAGE, position_m).angles_rad * STEPS_PER_RAD).astype(np.int64)
    recorder.target(now_ns, number, position_m, counts)
    larger = 1.0 if number in ON_PATH else 10.0
    true_m = position_m + larger * np.array(drawn.truth_error_m)
    if drawn.with_truth:
        recorder.truth(now_ns, true_m, (0.1, 0.2, 0.3))
    if not drawn.with_readings:
        return
    axes = np.eye(3) if drawn.axes is None else np.array(drawn.axes)
    for row, (axis, late_ms) in enumerate(zip("xyz", drawn.stagger_ms, strict=True)):
        if (axis, number) in drawn.silent:
            continue
        seen_m = target(number + late_ms / 20) + larger * np.array(drawn.range_error_m)
        distance_m = float((0.6, 0.6, 0.9)[row] + axes[row] @ seen_m)
        gate = Gate.SIGNAL if (axis, number) in drawn.weak else Gate.GOOD
        recorder.reading(Sample(axis, now_ns + round(late_ms * MS), distance_m, number, gate))
