"""The soak on the virtual clock: a working day of a robot, over and over; and a soak's table."""

from __future__ import annotations

import gc
import itertools
import os
import random
import re
import shutil
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from deltactl.drivers.steps.contract import Ticks
from deltactl.firmware_py.controller.build import build_controller
from deltactl.firmware_py.controller.contract import JobResult
from deltactl.firmware_py.controller.sensing.verify import verify
from deltactl.firmware_py.daemon.actions import Actions
from deltactl.firmware_py.daemon.address import Peer
from deltactl.firmware_py.daemon.job_store import JobStore
from deltactl.firmware_py.daemon.protocol import Message, Request
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.foundation.clock import NS_PER_S, sleep_s
from deltactl.recording.writing.retention import GIB, KeptRecordings, RecordingKeeper
from tests.rigs.faults.vitals import Vitals, vitals

MOST_SHOWN = 300
_NUMBERS = re.compile(r"[0-9]+(?:[-.T:][0-9]+)*")
WARM_UP = 0.15
"""The first part of a soak loads, fills buffers and caches: slopes are taken after it."""


@dataclass(frozen=True, slots=True)
class Sample:
    """One look. `drift`: worst difference of counters and drives [steps]."""

    hours: float
    vitals: Vitals
    drift: int
    edges_missed: int
    recordings: int
    recorded_mb: float
    oldest_s: float
    free_mb: float


@dataclass
class Tally:
    """What happened, and what was wrong."""

    samples: list[Sample] = field(default_factory=list)
    happened: dict[str, int] = field(default_factory=dict)
    problems: list[str] = field(default_factory=list)

    def count(self, what: str, times: int = 1) -> None:
        """Something happened."""
        self.happened[what] = self.happened.get(what, 0) + times

    def rows(self) -> list[str]:
        """The table."""
        hours = np.array([sample.hours for sample in self.samples])
        late = hours >= WARM_UP * hours[-1]
        rows = [f"{'':28}{'first':>12}{'last':>12}{'worst':>12}{'slope an hour':>16}"]
        for name, values in self._columns().items():
            slope = np.polyfit(hours[late], values[late], 1)[0] if late.sum() > 2 else np.nan
            figures = (values[late][0], values[-1], values.max())
            rows.append(f"{name:28}" + "".join(f"{v:12.1f}" for v in figures) + f"{slope:16.3f}")
        rows.append("  ".join(f"{what}: {n}" for what, n in sorted(self.happened.items())))
        kinds = Counter(_NUMBERS.sub("*", problem)[:MOST_SHOWN] for problem in self.problems)
        return [*rows, *(f"NOT AS IT SHOULD BE, {n} times: {kind}" for kind, n in kinds.items())]

    def _columns(self) -> dict[str, np.ndarray]:  # type: ignore[type-arg]
        of = self.samples
        return {
            "resident memory, MB": np.array([s.vitals.rss_kb / 1024 for s in of]),
            "open files": np.array([float(s.vitals.files) for s in of]),
            "threads": np.array([float(s.vitals.threads) for s in of]),
            "counter against drive, steps": np.array([float(s.drift) for s in of]),
            "edges not yet reported": np.array([float(s.edges_missed) for s in of]),
            "recordings": np.array([float(s.recordings) for s in of]),
            "recordings, MB": np.array([s.recorded_mb for s in of]),
            "oldest recording, s (wall)": np.array([s.oldest_s for s in of]),
            "free on the disk, MB": np.array([s.free_mb for s in of]),
        }


ROBOT = CONFIG_FOLDER / "zhao-2023.yaml"
SHIFT_S, BREAK_S, OFF_S = 1800.0, 1200.0, 600.0
"""Parts of every hour: jobs one after another, switched on and at rest, switched off."""
LOOK_S = 0.5
SAMPLE_S = 120.0
MB = 2**20
SIZE_MB, BALLAST_SPARE_MB, AGE_S = 24.0, 12.0, 45.0
"""Rotation, in turns: by size; for free space beside a growing other file; by age (wall time)."""
BALLAST_GROWS_MB = 0.2
"""Growth of that other file at every look: it takes 6 of the 12 MB in an hour."""
REPORT_HOURS = 1.0


class VirtualSoak:
    """One robot, its jobs, and what is looked at."""

    def __init__(self, folder: Path, seed: int):
        self.folder = folder / "recordings"
        self.folder.mkdir(parents=True, exist_ok=True)
        self.tally = Tally()
        self._random = random.Random(seed)
        self._jobs = _job_files(folder / "jobs")
        self.controller = build_controller(
            ROBOT, simulated=True, realtime=False, recordings=self.folder
        )
        self.clock = self.controller.clock
        self._actions = Actions(self.controller, JobStore(folder / "sent"), self.folder, self._note)
        self._actions.checks.start()
        self._edges_told = [0, 0, 0]
        self._offset = (0, 0, 0)
        self._ballast = self.folder / "something.else"
        self._sampled_s = 0.0
        self._shifts = itertools.count()
        self._kept = KeptRecordings(max_gib=SIZE_MB * MB / GIB, keep_free_gib=0.0)
        output = self.controller.machine.output
        self._take_sent = output.take_sent
        output.take_sent = self._tell  # type: ignore[method-assign]

    @property
    def now_s(self) -> float:
        """Virtual time."""
        return self.clock.now_ns() / NS_PER_S

    def run(self, hours: float) -> None:
        """Whole hours of shifts, breaks and nights; stops in the middle when the time is over."""
        end_s = hours * 3600.0
        while True:
            self._rotate_by(next(self._shifts) % 3)
            self._do("on")
            self._home()
            self._shift(min(end_s, self.now_s + SHIFT_S))
            self._idle(min(end_s, self.now_s + BREAK_S))
            self._do("off")
            self._idle(min(end_s, self.now_s + OFF_S))
            if self.now_s >= end_s:
                break
        self._sample()

    def _shift(self, until_s: float) -> None:
        for number, job in zip(itertools.count(1), itertools.cycle(self._jobs), strict=False):
            if self.now_s >= until_s:
                return
            self._job(job)
            if number % 4 == 0:
                self._home()
            if number % 6 == 0:
                self._verify()

    def _job(self, job: Path) -> None:
        number = self._do("run", job=str(job))["job_id"]
        pause_at_s = self.now_s + self._random.uniform(5.0, 60.0)
        cancel_at_s = self.now_s + self._random.uniform(60.0, 1200.0)
        while self._do("result", job_id=number)["result"] is None:
            self._sleep(LOOK_S)
            if pause_at_s < self.now_s:
                pause_at_s = self.now_s + self._random.uniform(60.0, 300.0)
                self._pause()
            if cancel_at_s < self.now_s:
                cancel_at_s = float("inf")
                self._maybe("cancel")
        self._ended(self._do("result", job_id=number)["result"])

    def _ended(self, result: Message) -> None:
        self.tally.count(f"jobs {result['outcome']}")
        for key in ("warning", "recording_error"):
            if result[key]:
                self.tally.problems.append(f"{result['name']}: {result[key]}")
        if result["outcome"] in ("fault", "stopped", "refused"):
            self.tally.problems.append(f"{result['name']} ended as {result}")

    def _pause(self) -> None:
        if self._maybe("pause"):
            self._sleep(self._random.uniform(0.1, 20.0))
            self._maybe("resume")

    def _home(self) -> None:
        self._do("home")
        counts, there = self.controller.status().counts, self._drives()
        self._offset = tuple(a - b for a, b in zip(counts, there, strict=True))  # type: ignore[assignment]
        self.tally.count("homed")

    def _verify(self) -> None:
        def follow(number: int) -> JobResult:
            while (result := self.controller.result(number)) is None:
                self._sleep(LOOK_S)
            self._ended(asdict(result))
            return result

        found = verify(self.controller, self.controller.robot, self._jobs[0], follow, self._sleep)
        self.tally.count("verified")
        if found.lost:
            self.tally.problems.append(found.says())

    def _idle(self, until_s: float) -> None:
        while self.now_s < until_s:
            self._sleep(min(10.0, until_s - self.now_s))

    def _sleep(self, duration_s: float) -> None:
        sleep_s(self.clock, duration_s)
        if self.now_s - self._sampled_s >= SAMPLE_S:
            self._sampled_s = self.now_s
            self._sample()

    def _do(self, do: str, **arguments: object) -> Message:
        answer = self._ask(do, **arguments)
        if not answer["ok"]:
            raise RuntimeError(f"{do}: {answer['error']}")
        return answer

    def _maybe(self, do: str) -> bool:
        """Ask for what the job's end may have made impossible."""
        done = bool(self._ask(do)["ok"])
        self.tally.count(f"{do} {'' if done else 'came too late'}".strip())
        return done

    def _ask(self, do: str, **arguments: object) -> Message:
        request = Request(None, do, arguments)
        return self._actions.perform(request, Peer(os.getpid(), os.getuid()))

    def _note(self, text: str) -> None:
        self.controller.journal.event(self.clock.now_ns(), "request", text)

    def _tell(self) -> Ticks:
        sent = self._take_sent()
        for motor, edges in enumerate((sent.steps != 0).sum(axis=0).tolist()):
            self._edges_told[motor] += edges
        return sent

    def _drives(self) -> tuple[int, int, int]:
        bench = self.controller.machine.bench
        assert bench is not None
        return bench.counts()

    def _rotate_by(self, turn: int) -> None:
        """Size, free space, age in turns; every one is the limit that binds."""
        self.tally.count(f"shifts with recordings kept by {('size', 'space', 'age')[turn]}")
        self._ballast.unlink(missing_ok=True)
        free_gib = 0.0
        if turn == 1:
            self._ballast.write_bytes(bytes(MB))
            spare = shutil.disk_usage(self.folder).free / MB + self._recorded()[1]
            free_gib = (spare - BALLAST_SPARE_MB) * MB / GIB
        size_gib = SIZE_MB * MB / GIB
        days = AGE_S / 86_400.0 if turn == 2 else None
        self._kept = KeptRecordings.model_construct(
            max_gib=size_gib, keep_free_gib=max(0.0, free_gib), max_age_days=days
        )

    def _sample(self) -> None:
        if self._ballast.exists():
            with self._ballast.open("ab") as growing:
                growing.write(bytes(round(BALLAST_GROWS_MB * MB)))
        gone = RecordingKeeper(self.folder, self._kept).tidy()
        self.tally.count("recordings deleted", len(gone))
        bench = self.controller.machine.bench
        assert bench is not None
        drift = zip(self.controller.status().counts, self._drives(), self._offset, strict=True)
        told = zip(bench.memory.edges(), self._edges_told, strict=True)
        number, size_mb, oldest_s = self._recorded()
        self.tally.samples.append(
            Sample(
                self.now_s / 3600.0,
                vitals(),
                max(abs(count - there - offset) for count, there, offset in drift),
                max(edges - known for edges, known in told),
                number,
                size_mb,
                oldest_s,
                shutil.disk_usage(self.folder).free / MB,
            )
        )
        self._check_rotation(number, size_mb, oldest_s)

    def _check_rotation(self, number: int, size_mb: float, oldest_s: float) -> None:
        kept, free = self._kept, shutil.disk_usage(self.folder).free / GIB
        days = kept.max_age_days
        if number <= 2:  # the one being written and the newest always stay
            return
        if size_mb > kept.max_gib * GIB / MB + 1.0:
            self.tally.problems.append(f"{size_mb:.0f} MB of recordings at {self.now_s:.0f} s")
        if free < kept.keep_free_gib:
            self.tally.problems.append(f"{free:.3f} GiB free at {self.now_s:.0f} s")
        if days is not None and oldest_s > days * 86_400.0 + 1.0:
            self.tally.problems.append(f"a recording {oldest_s:.0f} s old at {self.now_s:.0f} s")

    def _recorded(self) -> tuple[int, float, float]:
        found = [path.stat() for path in self.folder.glob("*.mcap")]
        oldest_s = time.time() - min((file.st_mtime for file in found), default=time.time())
        return len(found), sum(file.st_size for file in found) / MB, oldest_s


def _job_files(folder: Path) -> list[Path]:
    """The heart for verifying, and longer ones."""
    folder.mkdir(parents=True, exist_ok=True)
    made = []
    for name, repeats in (("heart", 1), ("heart", 6), ("circle", 8), ("spiral", 3)):
        text = (CONFIG_FOLDER / f"{name}.yaml").read_text(encoding="utf-8")
        lines = [line for line in text.splitlines() if not line.startswith("repeats:")]
        path = folder / f"{name}-{repeats}.yaml"
        path.write_text("\n".join([*lines, f"repeats: {repeats}", ""]), encoding="utf-8")
        made.append(path)
    return made


def _reports(soak: VirtualSoak, hours: float) -> Iterator[float]:
    """Run an hour at a time."""
    done = 0.0
    while done < hours:
        done = min(hours, done + REPORT_HOURS)
        soak.run(done)
        yield done


def soak_virtual(hours: float, folder: Path, seed: int) -> int:
    """Run, print the table; 1 when something is not as it should be."""
    gc.freeze()
    soak = VirtualSoak(folder, seed)
    start_s, start_cpu_s = time.monotonic(), time.process_time()
    try:
        for done in _reports(soak, hours):
            last = soak.tally.samples[-1]
            cpu_s = time.process_time() - start_cpu_s
            print(
                f"{done:5.1f} h in {time.monotonic() - start_s:6.0f} s ({cpu_s:.0f} s CPU): {last}",
                flush=True,
            )
    except KeyboardInterrupt:
        print("interrupted")
    soak.controller.close()
    cpu_s, wall_s = time.process_time() - start_cpu_s, time.monotonic() - start_s
    print(f"{soak.now_s / 3600.0:.1f} h of simulated running in {wall_s:.0f} s, {cpu_s:.0f} s CPU")
    print("\n".join(soak.tally.rows()))
    worst = soak.tally.samples
    bad = any(sample.drift for sample in worst) or bool(soak.tally.problems)
    return int(bad)
