"""What `deltactl convert` takes for long files, and `check` for the job that it makes of one.

python -m benchmarks.costs.convert [--only NAME]
"""

from __future__ import annotations

import argparse
import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

MOVES = 100_000
ROBOT = "my-delta.yaml"
DIMENSIONS = {
    "base-radius-mm": 120,
    "platform-radius-mm": 40,
    "upper-arm-mm": 150,
    "forearm-mm": 320,
    "gear-ratio": 5,
    "microsteps-per-rev": 1600,
}


def short_moves(count: int) -> Iterator[str]:
    """Hops of 0.01 mm round a circle."""
    yield "G21 G90\nG0 X0 Y0 Z0\n"
    for n in range(count):
        x, y = 10 * math.cos(n * 0.001) - 10, 10 * math.sin(n * 0.001)
        yield f"G1 X{x:.4f} Y{y:.4f} F3000\n"


def slicer(count: int) -> Iterator[str]:
    """Layers of outlines as a slicer writes them: 0.3 to 1.6 mm long, rounded, with filament."""
    yield "; made by a slicer\nG21\nG90\nM82\nM104 S200\nG92 E0\nG0 X0 Y0 Z0.2\n"
    for n in range(count):
        layer, part = divmod(n, 100)
        if not part:
            yield f";LAYER:{layer}\nM106 S127\nG92 E0\nG1 Z{0.2 + 0.2 * (layer % 100):.3f} F7800\n"
        radius, angle = 5 + 7.3 * layer % 20, 2 * math.pi * part / 100
        x, y = radius * math.cos(angle), radius * math.sin(angle)
        yield f"G1 X{x:.3f} Y{y + 0.05 * (n * 7 % 3):.3f} E{0.0312 * part:.5f}\n"


def arcs(count: int) -> Iterator[str]:
    """Thirds of small circles and lines between them, with a corner at each end."""
    yield "G21 G90\nG0 X0 Y0 Z0 F1800\n"
    for n in range(count // 2):
        x, y = 3.0 * (n % 15), 3.0 * (n // 15 % 15)
        yield f"G1 X{x:.3f} Y{y:.3f}\nG{2 + n % 2} X{x + 1:.3f} Y{y:.3f} R0.577351\n"


def few_moves(count: int) -> Iterator[str]:
    """Comments, powers and heaters, and three moves."""
    yield "G21 G90\nG0 X0 Y0 Z0\nG1 X5 F3000\n"
    for n in range(count // 4):
        yield f"; comment {n}\nS{n % 255}\nM106 S{n % 255}\n(x)\n"
    yield "G1 X0\n"


def table(count: int) -> Iterator[str]:
    """Points with a speed."""
    yield "x [mm],y [mm],z [mm],speed\n"
    for n in range(count):
        x, y = 10 * math.cos(n * 0.001) - 10, 10 * math.sin(n * 0.001)
        yield f"{x:.4f},{y:.4f},{math.sin(n * 0.01):.4f},50\n"


@dataclass(frozen=True)
class Case:
    """A file, and how many lines it has."""

    says: str
    name: str
    lines: Callable[[int], Iterable[str]]
    count: int


CASES = (
    Case("short moves round a circle", "short.gcode", short_moves, MOVES - 2),
    Case("a slicer's layers", "slicer.gcode", slicer, MOVES - 1010),
    Case("lines and arcs (G2, G3)", "arcs.gcode", arcs, 40_000),
    Case("a table of points", "points.csv", table, MOVES),
    Case("comments and M codes, 3 moves", "few.gcode", few_moves, 5 * MOVES),
    Case("short moves, refused", "many.gcode", short_moves, 3 * MOVES),
)


def run(folder: Path, *arguments: str) -> tuple[int, float, float, float]:
    """Status, time [s], time of the processor [s] and memory [MB] of a command."""
    began_s = time.monotonic()
    child = subprocess.Popen(
        [sys.executable, "-m", "deltactl.cli.main", *arguments],
        cwd=folder,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env=os.environ | {"PYTHONPATH": str(Path(__file__).resolve().parents[2])},
    )
    _, status, used = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    took_s = time.monotonic() - began_s
    return child.returncode, took_s, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def main(arguments: list[str]) -> int:
    """Print a row for each file."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--only", default="", help="part of a file's name")
    only = parser.parse_args(arguments).only
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        sizes = [text for key, size in DIMENSIONS.items() for text in (f"--{key}", str(size))]
        run(folder, "init", "delta", ROBOT, *sizes)
        print("| file | lines | exit status | s | s of the processor | MB |")
        print("|---|---|---|---|---|---|")
        for case in (one for one in CASES if only in one.name):
            path = folder / case.name
            path.write_text("".join(case.lines(case.count)))
            lines = path.read_bytes().count(b"\n")
            job = path.with_suffix(".yaml").name
            figures = run(
                folder, "convert", case.name, job, "--robot", ROBOT, "--origin", "0 0 -300"
            )
            _print(f"convert: {case.says}", lines, *figures)
            if (folder / job).exists() and lines <= 2 * MOVES:
                _print(f"check: {case.says}", lines, *run(folder, "check", job))
    return 0


def _print(says: str, lines: int, status: int, took_s: float, cpu_s: float, most_mb: float) -> None:
    cells = (says, f"{lines:,}", status, f"{took_s:.1f}", f"{cpu_s:.1f}", f"{most_mb:.0f}")
    print("|", " | ".join(map(str, cells)), "|", flush=True)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
