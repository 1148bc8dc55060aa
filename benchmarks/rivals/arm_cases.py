"""Draw arms in motion, in the environment where Pinocchio is.

    python -m benchmarks.rivals.arm_cases SEED COUNT FOLDER

Every other arm is healthy, the others hide one or two faults that have a name; of each the first
60 s are the recording and the next 30 s are held out.
"""

from __future__ import annotations

import gzip
import itertools
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from benchmarks.proofs.drawn_arms import SECONDS, drawn, tier_of
from benchmarks.proofs.moving_machines import ARM
from benchmarks.rivals.arm_signals import URDF

HELD_OUT_S = 30.0
TRUTHS = "truths.json"


def numbers(tiers: tuple[str, ...]) -> Iterator[int]:
    """Numbers of machines of these tiers."""
    return (number for number in itertools.count() if tier_of(number) in tiers)


def write_arm(seed: int, number: int, folder: Path) -> dict[str, Any]:
    """Recording, held-out part and URDF of one arm; what it hides, which no tool sees."""
    folder.mkdir()
    table = (folder / URDF).with_suffix(".csv")
    _, draw, _ = drawn(seed, number, False, table, SECONDS + HELD_OUT_S)
    head, *rows = table.read_text(encoding="utf-8").splitlines(keepends=True)
    table.unlink()
    begins = [float(row.partition(",")[0]) < SECONDS for row in rows]
    for name, part in (("recording", True), ("holdout", False)):
        own = [row for row, early in zip(rows, begins, strict=True) if early == part]
        with gzip.open(folder / f"{name}.csv.gz", "wt", encoding="utf-8") as text:
            text.writelines([head, *own])
    values = {"joints": list(ARM), "effort_gain": [1.0] * len(ARM)}
    (folder / "robot.json").write_text(json.dumps(values), encoding="utf-8")
    return {"case": folder.name, "hidden": draw.expected}


def main(seed: int, count: int, folder: Path) -> None:
    """Write so many cases and, beside their folder, what they hide."""
    healthy, faulty = numbers(("none",)), numbers(("single", "pair"))
    truths = []
    for place in range(count):
        number = next(faulty if place % 2 else healthy)
        truths.append(write_arm(seed, number, folder / f"arm_{place + 1:04d}"))
    text = json.dumps(truths)
    folder.with_name(f"{folder.name}-{TRUTHS}").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]), Path(sys.argv[3]))
