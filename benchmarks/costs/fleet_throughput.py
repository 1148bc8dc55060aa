"""A fleet: benchmarks/costs/fleet_throughput.py [--robots 40] [--recordings 50] [--keep FOLDER].

Simulates half a year of machines with code of its own (`fleet_machines`; nothing of models/):
among them three whose play grows, a batch of five with a wrong ratio (`--machine axis`) or with
wrong arms (`--machine delta`), and some files cut off. Diagnoses them and prints: recordings an
hour and core with 1 and 2 local workers and through a scheduler's address, memory of the workers
over time, and whether trends and batch were found. A whole fleet of deltas is
--machine delta --robots 40 --recordings 50 --once --keep FOLDER (2 000 recordings, an hour on two
cores; asked again, it goes on where it stopped).
"""

from __future__ import annotations

import argparse
import contextlib
import shutil
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import psutil

from benchmarks.costs.fleet_machines import (
    AXIS_FILE,
    AXIS_SPAN_S,
    DELTA_FILE,
    DELTA_SPAN_S,
    Concealed,
    record_axis,
    record_delta,
)
from deltactl.fleet.run import Workers, diagnose_fleet
from deltactl.fleet.together import courses, groups, trends
from deltactl.models.effects.gear_backlash import EFFECT as PLAY

DAYS = 180
GROWING, BATCH = 3, 5
FIRST = datetime(2026, 1, 1, 8, tzinfo=UTC)


@dataclass(frozen=True)
class Kind:
    """Machines of one kind: their file, how they record, what grows and what a batch has."""

    file: str
    record: Callable[[Path, np.random.Generator, Concealed], None]
    first_play_rad: float
    last_play_rad: float
    """At the start and at the end of the half year."""
    batch: Concealed
    span_s: float
    most_play_rad: float

    @property
    def limit(self) -> dict[str, float]:
        """For a trend: the play that is too much."""
        return {f"{PLAY.name}.{PLAY.main.name}": self.most_play_rad}


KINDS = {
    "axis": Kind(
        AXIS_FILE, record_axis, 0.0005, 0.006, Concealed(ratio=1.004), AXIS_SPAN_S, 0.0087
    ),
    "delta": Kind(
        DELTA_FILE, record_delta, 0.001, 0.012, Concealed(arm=1.012), DELTA_SPAN_S, 0.0175
    ),
}


def make_fleet(
    folder: Path, robots: int, recordings: int, seed: int = 1, machine: str = "axis"
) -> int:
    """Write robot files and recordings; returns how many files are broken on purpose."""
    kind = KINDS[machine]
    rng = np.random.default_rng(seed)
    (folder / "robots").mkdir(parents=True)
    broken = 0
    for robot in range(robots):
        name = f"{machine}-{robot:02d}"
        (folder / "robots" / f"{name}.yaml").write_text(kind.file.format(name=name))
        (folder / "runs" / name).mkdir(parents=True)
        for number in range(recordings):
            part = number / max(1, recordings - 1)
            low, high = kind.first_play_rad, kind.last_play_rad
            its = Concealed()
            if robot < GROWING:
                its = Concealed(play_rad=low + part * (high - low))
            elif robot < GROWING + BATCH:
                its = kind.batch
            when = FIRST + timedelta(days=part * DAYS, hours=float(rng.uniform(0, 6)))
            path = folder / "runs" / name / f"{name}-{when:%Y-%m-%dT%H-%M-%S}.csv"
            kind.record(path, rng, its)
            if number == 1 and robot % 10 == 9:
                path.write_bytes(path.read_bytes()[:40])
                broken += 1
    return broken


class Watch:
    """Recordings done, seconds, and the memory of all our processes at every tenth."""

    def __init__(self) -> None:
        self.started_s, self.first_s, self.done = time.monotonic(), 0.0, 0
        self.memory_mb: list[float] = []

    def __call__(self, done: int, of: int, row: dict[str, object]) -> None:
        if not self.done:
            self.first_s = time.monotonic()
        self.done += 1
        if done % max(1, of // 10) == 0:
            self.memory_mb.append(_memory_mb())

    def an_hour(self) -> float:
        """Recordings an hour once the workers were there."""
        return 3600.0 * (self.done - 1) / max(1e-9, time.monotonic() - self.first_s)


def _memory_mb() -> float:
    found = 0
    for process in [psutil.Process(), *psutil.Process().children(recursive=True)]:
        with contextlib.suppress(psutil.Error):
            found += process.memory_info().rss
    return found / 2**20


def _measured(name: str, cores: int, call: Callable[[Watch], object]) -> None:
    watch = Watch()
    call(watch)
    hour, memory = watch.an_hour(), watch.memory_mb or [_memory_mb()]
    pace = f"{hour:>9.0f} an hour{hour / cores:>9.0f} a worker"
    print(f"{name:<34}{pace}   memory {', '.join(f'{mb:.0f}' for mb in memory)} MB", flush=True)


def main() -> None:
    """Simulate, diagnose, and hold the answer against what was built in."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robots", type=int, default=10)
    parser.add_argument("--recordings", type=int, default=10)
    parser.add_argument("--machine", choices=list(KINDS), default="axis")
    parser.add_argument("--keep", type=Path, help="folder for the fleet, its answers and its page")
    parser.add_argument("--once", action="store_true", help="2 local workers and nothing else")
    given = parser.parse_args()
    kind = KINDS[given.machine]
    with tempfile.TemporaryDirectory(prefix="fleet-") as place:
        folder = given.keep or Path(place)
        broken = given.robots // 10
        if not (folder / "robots").is_dir():
            broken = make_fleet(folder, given.robots, given.recordings, machine=given.machine)
        pattern, robots, out = str(folder / "runs/**/*.csv"), folder / "robots", folder / "out"
        count = given.robots * given.recordings
        print(f"{count} recordings of {given.robots} robots, {kind.span_s:g} s each")
        for workers in (2,) if given.once else (1, 2):
            if not given.once:
                shutil.rmtree(out, ignore_errors=True)
            diagnosing = partial(diagnose_fleet, pattern, robots, out, Workers(workers), kind.limit)
            _measured(f"{workers} local worker{'s' * (workers > 1)}", workers, diagnosing)
        if not given.once:
            shutil.rmtree(out, ignore_errors=True)
            _through_scheduler(pattern, robots, out, kind)
        _judge(pattern, robots, out, broken, given.machine)


def _through_scheduler(pattern: str, robots: Path, out: Path, kind: Kind) -> None:
    import distributed

    make: Any = distributed
    with make.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster:
        address = cluster.scheduler_address
        diagnosing = partial(diagnose_fleet, pattern, robots, out, Workers(0, address), kind.limit)
        _measured("2 workers behind --scheduler", 2, diagnosing)


def _judge(pattern: str, robots: Path, out: Path, broken: int, machine: str) -> None:
    kind = KINDS[machine]
    again = Watch()
    rows = diagnose_fleet(pattern, robots, out, limits=kind.limit, progress=again)
    found = courses(rows)
    moving = trends(found, kind.limit)
    names = sorted({trend.course.key[0] for trend in moving})
    wanted = [f"{machine}-{number:02d}" for number in range(GROWING)]
    print(f"growing play: found on {', '.join(names) or 'none'}; built into {', '.join(wanted)}")
    true_rate = (kind.last_play_rad - kind.first_play_rad) / DAYS * 7.0
    for trend in moving:
        low, high = (7.0 * rate for rate in (trend.low_per_day, trend.high_per_day))
        week = f"{7 * trend.per_day:.2e} a week ({low:.2e} to {high:.2e})"
        print(f"  {trend.course.name}: {week}, true {true_rate:.2e}")
    for group in groups(found, moving):
        print(f"group: {group.effect} {group.median:.5f} on {', '.join(group.robots)}")
    last_ill = f"{machine}-{GROWING + BATCH - 1:02d}"
    healthy = [row for row in rows if "error" not in row and row["robot"] > last_ill]
    alarms = sum(row["verdict"] != "nothing_missing" for row in healthy)
    print(f"false alarms: {alarms} of {len(healthy)} recordings of healthy robots")
    bad = sum("error" in row for row in rows)
    print(f"bad files: {bad} told, {broken} made; asked again: {again.done} diagnosed anew")


if __name__ == "__main__":
    main()
