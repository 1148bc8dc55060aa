"""A fleet: benchmarks/costs/fleet_throughput.py [--robots 40] [--recordings 50] [--keep FOLDER].

Simulates half a year of geared axes with code of its own (play as a backlash operator, a wrong
ratio, white noise; nothing of models/), among them three whose play grows, a batch of five with a
wrong ratio, and some files cut off. Diagnoses them and prints: recordings an hour and core with 1
and 2 local workers and through a scheduler's address, memory of the workers over time, and whether
trends and batch were found. A whole fleet is --robots 40 --recordings 50
--once (2 000 recordings).
"""

from __future__ import annotations

import argparse
import contextlib
import math
import shutil
import tempfile
import time
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import psutil

from fleet.groups import groups
from fleet.run import diagnose_fleet
from fleet.trends import courses, trends

RAD_PER_STEP = 2.0 * math.pi / 16_000
SPAN_S, PERIOD_S, NOISE_RAD = 12.0, 0.02, 2e-4
DAYS = 180
GROWING, BATCH = 3, 5
RATIO = 1.004
PLAY_RAD = (0.0005, 0.006)
"""Of a growing play: at the start and at the end of the half year."""
FIRST = datetime(2026, 1, 1, 8, tzinfo=UTC)
LIMIT = {"gear_backlash.width": 0.0087}


def play(angles_rad: np.ndarray, width_rad: float) -> np.ndarray:
    """The classical backlash operator, sample by sample."""
    out, here = np.empty_like(angles_rad), float(angles_rad[0])
    for k, angle in enumerate(angles_rad):
        here = min(max(here, angle - 0.5 * width_rad), angle + 0.5 * width_rad)
        out[k] = here
    return out


def make_fleet(folder: Path, robots: int, recordings: int, seed: int = 1) -> int:
    """Write robot files and recordings; returns how many files are broken on purpose."""
    rng = np.random.default_rng(seed)
    (folder / "robots").mkdir(parents=True)
    broken = 0
    for robot in range(robots):
        name = f"axis-{robot:02d}"
        (folder / "robots" / f"{name}.yaml").write_text(
            f"kind: stepper_axis\nname: {name}\nzero: arbitrary\n"
            "drive: {microsteps_per_rev: 1600, gear_ratio: 10}\n"
        )
        (folder / "runs" / name).mkdir(parents=True)
        for number in range(recordings):
            part = number / max(1, recordings - 1)
            width = PLAY_RAD[0] + part * (PLAY_RAD[1] - PLAY_RAD[0]) if robot < GROWING else 0.0
            ratio = RATIO if GROWING <= robot < GROWING + BATCH else 1.0
            when = FIRST + timedelta(days=part * DAYS, hours=float(rng.uniform(0, 6)))
            path = folder / "runs" / name / f"{name}-{when:%Y-%m-%dT%H-%M-%S}.csv"
            _record(path, rng, width, ratio)
            if number == 1 and robot % 10 == 9:
                path.write_bytes(path.read_bytes()[:40])
                broken += 1
    return broken


def _record(path: Path, rng: np.random.Generator, width_rad: float, ratio: float) -> None:
    t_s = np.arange(0.0, SPAN_S, PERIOD_S)
    slow, fast = rng.uniform(4.0, 8.0), rng.uniform(1.5, 3.0)
    asked = 0.5 * np.sin(2 * np.pi * t_s / slow) + 0.2 * np.sin(2 * np.pi * t_s / fast)
    steps = np.round(asked / RAD_PER_STEP)
    theta = play(steps * RAD_PER_STEP * ratio, width_rad)
    theta += NOISE_RAD * rng.standard_normal(len(t_s))
    table = np.stack([t_s, steps, theta], axis=1)
    np.savetxt(path, table, fmt=("%.3f", "%d", "%.7f"), delimiter=",", comments="",
               header="t,steps_1,theta_1")  # fmt: skip


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


def _measured(
    name: str, folder: Path, out: Path, cores: int, call: Callable[[Watch], object]
) -> None:
    shutil.rmtree(out, ignore_errors=True)
    watch = Watch()
    call(watch)
    hour, memory = watch.an_hour(), watch.memory_mb
    print(f"{name:<34}{hour:>9.0f} an hour{hour / cores:>9.0f} a worker"
          f"   memory {memory[0]:.0f} to {memory[-1]:.0f} MB", flush=True)  # fmt: skip


def main() -> None:
    """Simulate, diagnose, and hold the answer against what was built in."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robots", type=int, default=10)
    parser.add_argument("--recordings", type=int, default=10)
    parser.add_argument("--keep", type=Path, help="folder for the last fleet and its page")
    parser.add_argument("--once", action="store_true", help="2 local workers and nothing else")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="fleet-") as place:
        folder = given.keep or Path(place)
        broken = make_fleet(folder, given.robots, given.recordings)
        pattern, robots, out = str(folder / "runs/**/*.csv"), folder / "robots", folder / "out"
        count = given.robots * given.recordings
        print(f"{count} recordings of {given.robots} robots, {SPAN_S:g} s each")
        for workers in (2,) if given.once else (1, 2):
            _measured(f"{workers} local worker{'s' * (workers > 1)}", folder, out, workers,
                      lambda watch, count=workers: diagnose_fleet(
                          pattern, robots, out, count, limits=LIMIT, progress=watch))  # fmt: skip
        if not given.once:
            _through_scheduler(pattern, robots, folder, out)
        _judge(pattern, robots, out, broken)


def _through_scheduler(pattern: str, robots: Path, folder: Path, out: Path) -> None:
    from distributed import LocalCluster

    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster:
        _measured("2 workers behind --scheduler", folder, out, 2, lambda watch: diagnose_fleet(
            pattern, robots, out, 0, str(cluster.scheduler_address), LIMIT, watch))  # fmt: skip


def _judge(pattern: str, robots: Path, out: Path, broken: int) -> None:
    again = Watch()
    rows = diagnose_fleet(pattern, robots, out, 0, limits=LIMIT, progress=again)
    found = courses(rows)
    moving = trends(found, LIMIT)
    names = sorted({trend.course.key[0] for trend in moving})
    wanted = [f"axis-{number:02d}" for number in range(GROWING)]
    print(f"growing play: found on {', '.join(names) or 'none'}; built into {', '.join(wanted)}")
    true_rate = (PLAY_RAD[1] - PLAY_RAD[0]) / DAYS * 7.0
    for trend in moving:
        low, high = (7.0 * rate for rate in (trend.low_per_day, trend.high_per_day))
        print(f"  {trend.course.name}: {7 * trend.per_day:.2e} a week ({low:.2e} to {high:.2e}), "
              f"true {true_rate:.2e}")  # fmt: skip
    for group in groups(found, moving):
        print(f"group: {group.effect} {group.median:.5f} on {', '.join(group.robots)}")
    healthy = [
        row
        for row in rows
        if "error" not in row and row["robot"] > f"axis-{GROWING + BATCH - 1:02d}"
    ]
    alarms = sum(row["verdict"] != "nothing_missing" for row in healthy)
    print(f"false alarms: {alarms} of {len(healthy)} recordings of healthy robots")
    bad = sum("error" in row for row in rows)
    print(f"bad files: {bad} told, {broken} made; asked again: {again.done} diagnosed anew")


if __name__ == "__main__":
    main()
