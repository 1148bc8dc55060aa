"""Small recordings that the tests of this folder share."""

from __future__ import annotations

import enum
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from deltactl.recording.format.configuration import RunConfiguration
from deltactl.recording.writing.writer import RunRecorder

MS = 1_000_000
START_NS = 5_000_000_000
EPOCH_NS = 1_700_000_000_000_000_000

CONFIGURATION = RunConfiguration(
    robot_text="kind: delta\nname: zhao-2023\n",
    job_text="name: heart\n",
    robot_name="zhao-2023",
    job_name="heart",
    version="0.1.0",
    simulated=True,
    start_epoch_ns=EPOCH_NS,
    settings={"t_pwm_s": 0.006},
)


class Gate(enum.Enum):
    """As in drivers, which recording does not know."""

    GOOD = "good"
    SIGNAL = "signal"


@dataclass(frozen=True)
class Sample:
    """A reading with the fields of `deltactl.drivers.ranging.contract.Reading`."""

    axis: str
    t_ns: int
    distance_m: float = 0.6
    status: int = 0
    raw_status: int = 9
    signal_mcps: float = 12.5
    ambient_mcps: float = 0.25
    sigma_m: float = 0.002
    stream_count: int = 0
    gate: Gate = Gate.GOOD


def record_round(recorder: RunRecorder, number: int) -> None:
    """One round at 50 Hz: three readings, counts, truth, ten edges."""
    now_ns = START_NS + number * 20 * MS
    for axis, off_ns in (("x", 0), ("y", 2 * MS), ("z", 4 * MS)):
        distance_m = 0.6 + number * 1e-4
        recorder.reading(Sample(axis, now_ns + off_ns, distance_m, stream_count=number % 256))
    recorder.target(now_ns, number, (0.1, number * 1e-4, -0.5), (number, -number, 2 * number))
    recorder.commanded(now_ns, (number, -number, 2 * number))
    recorder.truth(now_ns, (0.1, number * 1e-4, -0.5), (0.1, 0.2, 0.3))
    due_ns = now_ns + np.arange(10, dtype=np.int64) * 2 * MS
    recorder.edges(due_ns, np.tile(np.array([[1, -1, 0]], dtype=np.int8), (10, 1)))


@pytest.fixture
def sample() -> type[Sample]:
    """The reading that the tests record (tests cannot import one another)."""
    return Sample


@pytest.fixture
def configuration() -> RunConfiguration:
    """What the recordings say they are of."""
    return CONFIGURATION


@pytest.fixture
def recorder(tmp_path: Path) -> Iterator[RunRecorder]:
    """A recorder on a fresh file, closed at the end."""
    with RunRecorder(tmp_path / "run.mcap", CONFIGURATION, start_ns=START_NS) as opened:
        yield opened


@pytest.fixture
def recorded(tmp_path: Path) -> Callable[[int], Path]:
    """Makes a complete recording of some rounds."""

    def make(rounds: int) -> Path:
        path = tmp_path / "whole.mcap"
        with RunRecorder(path, CONFIGURATION, start_ns=START_NS, wait_when_behind=True) as opened:
            opened.settings(START_NS, 0.006)
            opened.pace(START_NS, 1.0, 0.0, 0.1)
            opened.event(START_NS, "path_start", "heart")
            for number in range(rounds):
                record_round(opened, number)
            opened.event(START_NS + rounds * 20 * MS, "path_end", "")
        assert not opened.failed
        return path

    return make
