"""What a diagnosis of 240 s takes: benchmarks/costs/diagnosis_cost.py [--cases 3] [--seed 1].

Draws recordings of the MuJoCo robot (extra `proof`) with nothing, one, two or three causes, one
among build tolerances, or unknown physics; runs `deltactl diagnose` on each in a process of
its own, and prints for each: seconds by the wall clock, seconds of processor time, and the most
memory that it and its helpers held together (proportional set size, looked at four times a second).
"""

from __future__ import annotations

import argparse
import gzip
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from deltactl.models.chain import Chain, Commands
from deltactl.models.robot_files import load_delta
from deltactl.proof.cases import HOLDOUT, RECORDING, ROBOT_FILE, assemble, write_blind
from deltactl.proof.hidden.oddities import ODDITIES
from deltactl.proof.hidden.vocabulary import SINGLES

COUNTS = {"nothing": 0, "single": 1, "two": 2, "three": 3, "tolerance": 1, "unknown": 1}
LENGTH_S = 240.0
LIMIT_S, LIMIT_MB = 10.0, 500.0
DAY_MB = 2048.0
PERIOD_S, TILE_S = 0.02, 600.0
LATE_S, NOISE_DEG = 0.04, 0.06
CONFIG = Path(__file__).resolve().parents[2] / "config"
LOOK_S = 0.25


class Cost(NamedTuple):
    """Cost of one diagnosis."""

    wall_s: float
    used_s: float
    memory_mb: float
    status: int


def cost(group: str, seed: int, number: int) -> tuple[list[str], Cost]:
    """What was hidden, and what its diagnosis takes."""
    rng = np.random.default_rng([seed, number, sum(group.encode())])
    names = sorted(ODDITIES) if group == "unknown" else list(SINGLES)
    kinds = [str(name) for name in rng.permutation(names)[: COUNTS[group]]]
    case = assemble(number, group, kinds, rng, motion="survey", seconds=LENGTH_S)
    with tempfile.TemporaryDirectory(prefix="cost-") as folder:
        write_blind(case, Path(folder), seed)
        return kinds, _diagnosed(Path(folder))


def day(seed: int, hours: float) -> Cost:
    """A day of a healthy robot at 50 Hz as CSV: ten minutes over and over, each with new noise."""
    robot = load_delta(CONFIG / "zhao-2023.yaml")
    assert robot.drive is not None
    rng = np.random.default_rng(seed)
    t_s = PERIOD_S * np.arange(round(TILE_S / PERIOD_S))
    # A whole number of waves: one tile goes on where the one before it ended.
    waves = 2.0 * np.pi * np.outer(t_s / TILE_S, (211.0, 173.0, 131.0))
    counts = np.round(1500.0 + 1200.0 * np.sin(waves))
    ranges_m = Chain(robot).simulate(Commands.of_counts(t_s, counts, robot.drive), ()).ranges
    names = ["t", *(f"steps_{k}" for k in (1, 2, 3)), *(f"range_{a}" for a in "xyz")]
    with tempfile.TemporaryDirectory(prefix="cost-") as folder:
        with gzip.open(Path(folder) / RECORDING, "wt", compresslevel=1) as file:
            file.write(",".join(names) + "\n")
            for number in range(round(hours * 3600.0 / TILE_S)):
                seen_m = ranges_m + 0.002 * rng.standard_normal(ranges_m.shape)
                rows = np.column_stack([number * TILE_S + t_s, counts, seen_m])
                np.savetxt(file, rows, fmt=["%.2f", *["%d"] * 3, *["%.3f"] * 3], delimiter=",")
        shutil.copy(CONFIG / "zhao-2023.yaml", Path(folder) / ROBOT_FILE)
        return _diagnosed(Path(folder), ())


def day_of_an_axis(seed: int, hours: float) -> tuple[Cost, str]:
    """A day of a servo axis at 50 Hz that is 40 ms late, as a table of others, and its answer."""
    rng = np.random.default_rng(seed)
    t_s = PERIOD_S * np.arange(round(hours * 3600.0 / PERIOD_S))
    moves = len(t_s) // 50 + 2
    took_s, rest_s = rng.uniform(0.6, 2.0, moves), rng.uniform(0.2, 3.0, moves)
    begins = np.cumsum(took_s + rest_s) - took_s
    moments = np.stack([begins, begins + took_s], axis=1).ravel()
    places = np.repeat(rng.uniform(-60.0, 60.0, moves + 1), 2)[1:-1]
    command = np.interp(t_s, moments, places)
    late = np.interp(t_s - LATE_S, moments, places) + NOISE_DEG * rng.standard_normal(len(t_s))
    with tempfile.TemporaryDirectory(prefix="cost-") as folder:
        table = Path(folder) / "day.csv"
        rows = np.column_stack([t_s, command, late])
        heading = "t,command[deg],theta[deg]"
        np.savetxt(table, rows, "%.3f", ",", header=heading, comments="")
        robot = Path(folder) / "axis.yaml"
        robot.write_text("kind: servo_axis\nname: day\nmotion: rotary\nzero: absolute\n")
        said = Path(folder) / "answer.json"
        took = _run(["diagnose", str(table), "--robot", str(robot), "--json", str(said)])
        answer = json.loads(said.read_text()) if took.status == 0 else {"findings": [], "fit": {}}
    found = [
        f"{one['effect']} {1e3 * one['parameters']['total']['value']:.1f} ms"
        if "total" in one["parameters"]
        else one["effect"]
        for one in answer["findings"]
    ]
    left_deg = np.rad2deg(answer["fit"].get("rms_after_m", np.nan))
    return took, f"{', '.join(found) or 'no finding'}; {left_deg:.4f} degrees left of {NOISE_DEG:g}"


def _diagnosed(folder: Path, held_out: Sequence[str] = (HOLDOUT,)) -> Cost:
    options = ["--robot", str(folder / ROBOT_FILE)]
    options += [word for name in held_out for word in ("--holdout", str(folder / name))]
    return _run(["diagnose", str(folder / RECORDING), *options])


def _run(words: Sequence[str]) -> Cost:
    """A command in a process of its own, and what it took."""
    begun_s = time.monotonic()
    process = subprocess.Popen(
        [sys.executable, "-m", "deltactl.cli.main", *words],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    most_mb = 0.0
    while True:
        most_mb = max(most_mb, sum(_held_mb(pid) for pid in _family(process.pid)))
        ended, status, used = os.wait4(process.pid, os.WNOHANG)
        if ended:
            break
        time.sleep(LOOK_S)
    wall_s = time.monotonic() - begun_s
    return Cost(wall_s, used.ru_utime + used.ru_stime, most_mb, os.waitstatus_to_exitcode(status))


def _family(pid: int) -> list[int]:
    """A process and all that came from it."""
    try:
        children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    except OSError:
        return []
    return [pid, *(other for child in children for other in _family(int(child)))]


def _held_mb(pid: int) -> float:
    """Memory of a process; what several share counts for each in part."""
    try:
        rows = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()
    except OSError:
        return 0.0
    return sum(float(row.split()[1]) / 1024 for row in rows if row.startswith("Pss:"))


def main() -> int:
    """Exit status 1 when a limit does not hold."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=3, help="of each kind")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--group", choices=COUNTS, action="append", help="only these")
    parser.add_argument("--day", action="store_true", help="a recording of a day instead")
    parser.add_argument("--axis", action="store_true", help="of a servo axis that is 40 ms late")
    parser.add_argument("--hours", type=float, default=24.0, help="of that day")
    options = parser.parse_args()
    if options.day:
        if options.axis:
            took, answer = day_of_an_axis(options.seed, options.hours)
            print(answer)
        else:
            took = day(options.seed, options.hours)
        print(
            f"{options.hours:g} h at 50 Hz: {took.wall_s:.1f} s, {took.used_s:.1f} s of processor"
        )
        print(f"{took.memory_mb:.0f} MB of {DAY_MB:.0f} MB, exit status {took.status}")
        return int(took.memory_mb > DAY_MB or took.status != 0)
    held = True
    print(f"{'hidden':10s} {'s':>6s} {'CPU s':>6s} {'MB':>5s}")
    for group in options.group or COUNTS:
        for number in range(1 if group == "nothing" else options.cases):
            kinds, took = cost(group, options.seed, number)
            held &= took.wall_s <= LIMIT_S and took.memory_mb <= LIMIT_MB
            refused = "" if took.status == 0 else f" (exit status {took.status})"
            print(
                f"{group:10s} {took.wall_s:6.1f} {took.used_s:6.1f} {took.memory_mb:5.0f} "
                f"{', '.join(kinds)}{refused}",
                flush=True,
            )
    print(f"{LIMIT_S:g} s and {LIMIT_MB:g} MB {'hold' if held else 'do not hold for all of them'}")
    return 0 if held else 1


if __name__ == "__main__":
    sys.exit(main())
