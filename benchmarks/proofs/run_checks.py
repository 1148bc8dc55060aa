"""What the check of every run announces: python -m benchmarks.proofs.run_checks [--healthy 200].

One delta (spheres of its own, benchmarks/costs/fleet_machines.py) runs 30 s at a time. First
healthy runs: nothing may be announced. Then its play grows to 0.2 degrees in steps of 0.02, and
stays. Printed: from which run on the play was larger than the smallest that the checks said they
would see (80 % power), which run announced it, and how far each run is from the next. Answers are
kept in --keep FOLDER and asked for once.
"""

from __future__ import annotations

import argparse
import json
import math
import tempfile
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.costs.fleet_machines import DELTA_FILE, Concealed, record_delta
from deltactl.fleet.checks import Announcement, standing
from deltactl.fleet.task import diagnose_one
from deltactl.models.effects.gear_backlash import EFFECT as PLAY

Row = dict[str, Any]
LAST_DEG, STEP_DEG, STAYS = 0.2, 0.02, 5


def growing_play_deg() -> list[float]:
    """Play of each run after the healthy ones."""
    steps = round(LAST_DEG / STEP_DEG)
    return [STEP_DEG * k for k in range(1, steps + 1)] + [LAST_DEG] * STAYS


def run(folder: str, number: int, play_deg: float) -> Row:
    """Record and check one run; the answer is kept."""
    kept = Path(folder) / f"run-{number:04d}-{play_deg:.2f}.json"
    if kept.exists():
        row: Row = json.loads(kept.read_text())
        return row
    recording = kept.with_suffix(".csv")
    robot = Path(folder) / "robot.yaml"
    rng = np.random.default_rng([7, number])
    record_delta(recording, rng, Concealed(play_rad=math.radians(play_deg)))
    row = diagnose_one(str(recording), str(robot))
    row |= {"recording": str(recording), "robot": "checked", "play_deg": play_deg}
    row["time_s"] = 3600.0 * number
    kept.write_text(json.dumps(row))
    return row


def announced_at(rows: list[Row]) -> Iterator[tuple[int, Announcement]]:
    """Each thing announced, and the run after which it first was."""
    known: set[tuple[str, str]] = set()
    for count in range(1, len(rows) + 1):
        for announced in standing(rows[:count]):
            if (announced.effect, announced.component) not in known:
                known.add((announced.effect, announced.component))
                yield count - 1, announced


def main() -> None:
    """Print what is announced."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--healthy", type=int, default=200)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--keep", type=Path)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="checks-") as place:
        folder = given.keep or Path(place)
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "robot.yaml").write_text(DELTA_FILE.format(name="checked"))
        plays = [0.0] * given.healthy + growing_play_deg()
        with ProcessPoolExecutor(given.workers) as pool:
            rows = list(pool.map(run, [str(folder)] * len(plays), range(len(plays)), plays))
    healthy, later = rows[: given.healthy], rows[given.healthy :]
    told = list(announced_at(healthy))
    found = sum(bool(row.get("findings")) for row in healthy)
    print(
        f"{len(healthy)} healthy runs: {len(told)} announced; single runs with a finding: {found}"
    )
    for number, announced in told:
        print(f"  after run {number}: {announced.says}")
    for row in later:
        its = [f for f in row.get("findings", []) if f["parameter"] == "width"]
        size = ", ".join(f"{math.degrees(f['value']):.3f} deg of {f['component']}" for f in its)
        seen = math.degrees(row.get("detectable", {}).get(f"{PLAY.name} motor1", math.nan))
        print(f"  play {row['play_deg']:.2f} deg, detectable {seen:.3f} deg, found {size or '-'}")
    _judge(later, healthy)


def _judge(later: list[Row], healthy: list[Row]) -> None:
    limits = [row.get("detectable", {}).get(f"{PLAY.name} motor1", math.nan) for row in later]
    plays = [math.radians(row["play_deg"]) for row in later]
    ready = next((k for k, play in enumerate(plays) if play >= limits[k]), None)
    told = [
        (k, announced.effect, announced.component)
        for k, announced in announced_at([*healthy, *later])
    ]
    when = next((k - len(healthy) for k, *its in told if its == [PLAY.name, "motor1"]), None)
    if when is None:
        print("the play was never announced")
        return
    said = "it was never larger than the smallest detectable"
    if ready is not None:
        said = f"it was detectable from run {ready} on, {when - ready} runs before"
    place = f"after run {when} of {len(later)}, at {later[when]['play_deg']:.2f} deg"
    print(f"play announced {place}; {said}")


if __name__ == "__main__":
    main()
