"""Well-formed recordings with any values in them: times, counts, angles, texts, NaN, huge numbers.

Bytes changed at random seldom leave a file that can be read to its end. Here the bytes say which
values stand where, in messages that are all whole; up to where a diagnosis begins to fit.
"""

from __future__ import annotations

import io
import json
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from deltactl.diagnosis.admission.admit import admit
from deltactl.diagnosis.plants.delta.safe_poses import MotionLimits
from deltactl.drivers.ranging.contract import Gate, Reading
from deltactl.foundation.strict_yaml import Document
from deltactl.models.chain import Chain, Commands
from deltactl.models.robot_files import load_delta
from deltactl.recording.format.channels import CHANNEL_IDS
from deltactl.recording.format.configuration import RunConfiguration
from deltactl.recording.reading.reader import read_run
from deltactl.recording.tables.flat import FlatRecording
from deltactl.recording.tables.rounds import flatten
from deltactl.recording.writing.append_file import AppendFile
from deltactl.recording.writing.container import Container, record_bytes
from deltactl.recording.writing.writer import RunRecorder

ROBOT = Path(__file__).parents[2] / "config" / "zhao-2023.yaml"
ROUNDS, PERIOD_NS = 80, 20_000_000
Message = tuple[str, dict[str, Any]]
"""Topic and fields."""
NUMBERS: tuple[Any, ...] = (
    *(0, -1, 1, 255, 2**31, 2**32, 2**53 + 1, 2**63 - 1, -(2**63), 2**63, -(2**70), 10**400),
    *(0.5, -0.0, 5e-324, 1e-12, 1e300, -1e300, math.nan, math.inf, -math.inf),
    *(True, None, "", "1", "\x1b[2J", "good" * 999, [], {"a": 1}, "AAAA", "////"),
)
"""Put in place of any field. Whole seconds and a year, as times, come by `TIMES`."""
TIMES: tuple[Callable[[int], int], ...] = (
    lambda t_ns: 0,
    lambda t_ns: -t_ns,
    lambda t_ns: t_ns - 10**9,
    lambda t_ns: t_ns // 10**9,
    lambda t_ns: t_ns * 1000,
    lambda t_ns: t_ns * 10**9,
    lambda t_ns: t_ns + 3 * 86_400 * 10**9,
    lambda t_ns: t_ns + 365 * 86_400 * 10**9,
    lambda t_ns: 2**63 - 1 - t_ns,
    lambda t_ns: t_ns - 2**63,
    lambda t_ns: 10**18 + t_ns,
    lambda t_ns: t_ns ^ 1 << 40,
)
"""Another time for a message."""
WORDS = tuple(bytes([255, topic, way, 0, 255]) for topic in (0, 3, 7) for way in range(len(TIMES)))
"""Instructions that set all times of a topic."""


class Recordings:
    """A well-formed recording of a robot that moves, made again with other values."""

    def __init__(self, folder: Path):
        self._path = folder / "values.mcap"
        self._robot = load_delta(ROBOT)
        self._limits = MotionLimits.of(Document.read(ROBOT).data)
        self._messages = _messages(folder)
        self._topics = sorted({topic for topic, _ in self._messages})
        self._head = head(folder)

    def write(self, data: bytes) -> Path:
        """The file that these bytes stand for."""
        body = b"".join(_with_fields(topic, fields) for topic, fields in self.changed(data))
        self._path.write_bytes(self._head + chunk(body))
        return self._path

    def read(self, data: bytes) -> FlatRecording:
        """Its rows. Raises RecordingError."""
        return flatten(read_run(self.write(data)))

    def admit(self, data: bytes) -> None:
        """All that a diagnosis does with it before it fits anything. Raises RecordingError."""
        admit(self._robot, [self.read(data)], limits=self._limits).passed()

    def changed(self, data: bytes) -> list[Message]:
        """Messages with five bytes for each change: field (255: its time), topic, value, first
        message and how many of them, in parts of 255.
        """
        messages = [(topic, dict(fields)) for topic, fields in self._messages]
        for at in range(0, len(data) - 4, 5):
            which, topic, value, first, count = data[at : at + 5]
            name = self._topics[topic % len(self._topics)]
            mine = [fields for topic, fields in messages if topic == name]
            begin = first * len(mine) // 256
            for fields in mine[begin : begin + 1 + count * len(mine) // 255]:
                _change(fields, which, value)
        return messages


def _change(fields: dict[str, Any], which: int, value: int) -> None:
    if which == 255 and isinstance(fields.get("t_ns"), int):
        fields["t_ns"] = TIMES[value % len(TIMES)](fields["t_ns"])
        return
    name = sorted(fields)[which % len(fields)]
    if value == 255:
        fields.pop(name)
        fields["other"] = 1
    else:
        fields[name] = NUMBERS[value % len(NUMBERS)]


def _with_fields(topic: str, fields: dict[str, Any]) -> bytes:
    t_ns = fields.get("t_ns")
    log_ns = int(t_ns) % 2**64 if isinstance(t_ns, int) else 0
    return packed(topic, log_ns, json.dumps(fields).encode())


def head(folder: Path) -> bytes:
    """What a recording begins with."""
    path = folder / "head.mcap"
    container = Container(AppendFile(path), "head")
    container._file.close()
    container._chunk_index.close()
    return path.read_bytes()


def packed(topic: str, log_ns: int, data: bytes) -> bytes:
    """A message as it stands in a chunk."""
    from mcap import records

    return record_bytes(records.Message(CHANNEL_IDS[topic], log_ns, data, log_ns, sequence=0))


def chunk(body: bytes) -> bytes:
    """Messages, uncompressed and without a checksum."""
    from mcap import records

    return record_bytes(records.Chunk("", body, 0, 0, 0, uncompressed_size=len(body)))


def _messages(folder: Path) -> list[Message]:
    """A run in which all arms move, written by the recorder and read back."""
    from mcap.reader import make_reader

    path = folder / "sound.mcap"
    with RunRecorder(path, RunConfiguration("robot", "job", start_epoch_ns=10**18)) as recorder:
        for write in _run():
            write(recorder)
    packed = io.BytesIO(path.read_bytes())
    path.unlink()
    return [
        (channel.topic, json.loads(message.data))
        for _, channel, message in make_reader(packed).iter_messages()
        if channel.topic in CHANNEL_IDS
    ]


def _run() -> Iterator[Callable[[RunRecorder], None]]:
    robot = load_delta(ROBOT)
    assert robot.drive is not None
    t_ns = PERIOD_NS * np.arange(ROUNDS)
    phase = np.arange(3) + 2e-9 * t_ns[:, None]
    counts = np.rint(1700.0 + 300.0 * np.sin(phase)).astype(int)
    commands = Commands.of_counts(1e-9 * t_ns, counts.astype(float), robot.drive)
    clean_m = Chain(robot).simulate(commands, ()).ranges
    noise_m = 1e-3 * np.random.default_rng(1).standard_normal(clean_m.shape)
    ranges = np.round(clean_m + noise_m, 3)
    yield lambda recorder: recorder.settings(0, 0.002)
    yield lambda recorder: recorder.counts_set(0, tuple(counts[0].tolist()))
    for k in range(1, ROUNDS):
        moved = counts[k] - counts[k - 1]
        many = int(np.abs(moved).max())
        due_ns = t_ns[k] - PERIOD_NS + (np.arange(many) + 1) * PERIOD_NS // (many + 1)
        steps = (np.arange(many)[:, None] < np.abs(moved)) * np.sign(moved)
        yield lambda recorder, d=due_ns, s=steps: recorder.edges(d, s.astype(np.int8))  # type: ignore[misc]
        for i, axis in enumerate("xyz"):
            light = (0, 9, 4.0, 0.1, 0.002, k % 256, Gate.GOOD)
            reading = Reading(axis, int(t_ns[k]), float(ranges[k, i]), *light)
            yield lambda recorder, r=reading: recorder.reading(r)  # type: ignore[misc]
        yield lambda recorder, k=k: recorder.commanded(int(t_ns[k]), tuple(counts[k].tolist()))  # type: ignore[misc]
        yield lambda recorder, k=k: recorder.event(int(t_ns[k]), "note", "text")  # type: ignore[misc]
