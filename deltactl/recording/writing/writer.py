"""The recorder: takes what happens from any thread, and never disturbs the motion."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from deltactl.foundation.errors import RecordingError
from deltactl.recording.format import messages
from deltactl.recording.format.channels import (
    CHANNEL_IDS,
    COMMANDED,
    CONFIGURATION,
    EDGES,
    EVENT,
    FORMAT,
    PACE,
    READINGS,
    SERVO,
    SETTINGS,
    TARGET,
    TRUTH,
    WRITTEN_BY,
    Channel,
    ViewedChannel,
)
from deltactl.recording.format.configuration import (
    JOB_ATTACHMENT,
    METADATA_NAME,
    ROBOT_ATTACHMENT,
    RunConfiguration,
)
from deltactl.recording.format.messages import (
    Int8Array,
    Int64Array,
    Message,
    ReadingLike,
    ServoLike,
    Steps,
    Three,
    blocks,
    counts_set,
)
from deltactl.recording.writing.append_file import AppendFile
from deltactl.recording.writing.container import Attachment, Container
from deltactl.recording.writing.spool import WAITING_BYTES, DiskThread, Spool

RESERVE_BYTES = 64 * 2**20
"""What a recording leaves free: a Pi with a full card does not boot."""
EDGES_PER_BLOCK = 8192
CLOSE_S = 10.0

_encode = json.JSONEncoder(separators=(",", ":")).encode


class RunRecorder:
    """Writes one run into one new MCAP file as it happens.

    All times are on the clock of the run; `start_ns` is its time 0, and the configuration's
    `start_epoch_ns` the wall clock then (now, if it has none). After a failure `failed` says why,
    `on_failure` is called once (from a thread of the recorder), and everything that comes later is
    counted in `lost`. Methods may be called from any thread and never raise OSError.

    With `wait_when_behind` (simulation) a caller waits for a slow disk; without it (robot)
    the recording fails instead.

    Raises RecordingError when the file exists, cannot be made, or the disk has too little room.
    """

    def __init__(
        self,
        path: Path,
        configuration: RunConfiguration,
        *,
        start_ns: int = 0,
        counts: Steps = (0, 0, 0),
        reserve_bytes: int = RESERVE_BYTES,
        wait_when_behind: bool = False,
        on_failure: Callable[[str], None] | None = None,
    ):
        self.path = path
        self.failed = ""
        self._start_ns = start_ns
        self._epoch_ns = configuration.start_epoch_ns or time.time_ns()
        self._on_failure = on_failure
        self._counts = np.array(counts, dtype=np.int64)
        self._times: list[Int64Array] = []
        self._steps: list[Int8Array] = []
        self._edges = 0
        self._spool = Spool(self._cut_edges, wait_when_behind)
        stamped = replace(configuration, start_epoch_ns=self._epoch_ns)
        file = AppendFile(path, reserve_bytes)
        container = _begin(file, stamped)
        self._disk = DiskThread(file, container, self._spool, self._fail)
        self._add(CONFIGURATION, stamped.as_message())
        self.counts_set(start_ns, self._counts)
        self._disk.start()

    @property
    def lost(self) -> int:
        """Messages that came after a failure or after `close`."""
        return self._spool.lost

    def target(self, t_ns: int, index: int, position_m: Three, steps: Steps) -> None:
        """A target, due at `t_ns`, and the counts it was turned into."""
        self._add(TARGET, messages.target(self._run_ns(t_ns), index, position_m, steps))

    def commanded(self, t_ns: int, steps: Steps) -> None:
        """The counts commanded at `t_ns`; wanted at least at every reading round."""
        self._add(COMMANDED, {"t_ns": self._run_ns(t_ns)} | messages.counts(steps))

    def edges(self, due_ns: Int64Array, steps: Int8Array) -> None:
        """Edges that really went out. Shapes (n,) and (n, 3); counted on from the ones before."""
        if not len(due_ns):
            return
        with self._spool.changed:
            self._times.append(np.array(due_ns, dtype=np.int64) - self._start_ns)
            self._steps.append(np.array(steps, dtype=np.int8))
            self._edges += len(due_ns)
            if self._edges >= EDGES_PER_BLOCK:
                self._cut_edges()

    def counts_set(self, t_ns: int, steps: Steps) -> None:
        """The step counters were set (homing) without anything moving."""
        with self._spool.changed:
            self._cut_edges()
            self._counts = np.array(steps, dtype=np.int64)
            self._add(EDGES, counts_set(self._run_ns(t_ns), self._counts).as_message())

    def reading(self, sample: ReadingLike) -> None:
        """One sample of one distance sensor."""
        message = messages.reading(self._run_ns(sample.t_ns), sample)
        self._add(READINGS[sample.axis], message)

    def event(self, t_ns: int, kind: str, text: str = "") -> None:
        """Something that happened; `kind` is one word, `text` a sentence for people."""
        self._add(EVENT, {"t_ns": self._run_ns(t_ns), "kind": kind, "text": text})

    def truth(self, t_ns: int, position_m: Three, angles_rad: Three) -> None:
        """Where the simulated robot really is."""
        self._add(TRUTH, messages.truth(self._run_ns(t_ns), position_m, angles_rad))

    def servo(self, sample: ServoLike) -> None:
        """What a servo's loop did over a stretch of ticks."""
        self._add(SERVO, messages.servo(self._run_ns(sample.t_ns), sample))

    def settings(self, t_ns: int, t_pwm_s: float | None) -> None:
        """The step period from `t_ns` on; None where every motor has its own."""
        self._add(SETTINGS, messages.settings(self._run_ns(t_ns), t_pwm_s))

    def pace(self, t_ns: int, rate: float, goal: float, ramp_s: float) -> None:
        """From `t_ns` on the pace of the path goes from `rate` to `goal` within `ramp_s`."""
        self._add(PACE, messages.pace(self._run_ns(t_ns), rate, goal, ramp_s))

    def wall_ns(self, t_ns: int) -> int:
        """Nanoseconds since 1970 at a time of the run's clock."""
        return max(0, self._epoch_ns + self._run_ns(t_ns))

    def viewed(self, t_ns: int, channel: ViewedChannel, message: Message) -> None:
        """A message for viewers, in the form of its schema; not read back."""
        self._put(channel.topic, self.wall_ns(t_ns), message)

    def flush(self) -> bool:
        """Wait until the system has everything so far. False after `CLOSE_S` or a failure."""
        self._spool.cut()
        return self._spool.wait_written(CLOSE_S) and not self.failed

    def close(self, timeout_s: float = CLOSE_S) -> None:
        """Write the rest and the summary. Safe to call twice; never raises."""
        self._spool.cut()
        self._spool.end()
        if not self._disk.join(timeout_s):
            self._fail(f"the disk did not answer for {timeout_s:g} s at the end")

    def __enter__(self) -> RunRecorder:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _run_ns(self, t_ns: int) -> int:
        return int(t_ns) - self._start_ns

    def _add(self, channel: Channel, message: Message) -> None:
        self._put(channel.topic, max(0, self._epoch_ns + message["t_ns"]), message)

    def _put(self, topic: str, log_ns: int, message: Message) -> None:
        if not self._spool.add(CHANNEL_IDS[topic], log_ns, _encode(message).encode()):
            reason = f"the disk is too slow, {WAITING_BYTES // 2**20} MiB are waiting"
            # Not from here: the caller may hold locks that the listener wants.
            threading.Thread(target=self._fail, args=(reason,), daemon=True).start()

    def _cut_edges(self) -> None:
        """Turn the edges collected so far into messages."""
        with self._spool.changed:
            if not self._edges:
                return
            due_ns, steps = np.concatenate(self._times), np.concatenate(self._steps)
            self._times, self._steps, self._edges = [], [], 0
            base = self._counts
            self._counts = base + steps.sum(axis=0, dtype=np.int64)
            for block in blocks(due_ns, steps, base):
                self._add(EDGES, block.as_message())

    def _fail(self, reason: str) -> None:
        with self._spool.changed:
            if self.failed:
                return
            self.failed = f"{self.path}: recording stopped: {reason}; kept up to there"
            self._spool.drop()
        if self._on_failure is not None:
            self._on_failure(self.failed)


def _begin(file: AppendFile, configuration: RunConfiguration) -> Container:
    """Write the head of every recording. Raises RecordingError."""
    start_ns = configuration.start_epoch_ns
    try:
        container = Container(file, library=f"{WRITTEN_BY}{configuration.version}, format {FORMAT}")
        container.add_metadata(METADATA_NAME, configuration.as_metadata())
        container.add_attachment(Attachment(ROBOT_ATTACHMENT, configuration.robot_text), start_ns)
        container.add_attachment(Attachment(JOB_ATTACHMENT, configuration.job_text), start_ns)
    except OSError as error:
        file.discard()
        raise RecordingError(f"{file.path}: cannot be written ({error.strerror})") from error
    return container
