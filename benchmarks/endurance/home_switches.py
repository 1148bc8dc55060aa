"""Homing by switches at random: python benchmarks/endurance/home_switches.py [-n 300] [--from 0].

Every draw is a home angle, what the ranging sensors see, and one or two troubles of switches,
wires, drives or starts (tests/rigs/switch_homing.py). Prints what is neither homed to within the
tolerance nor refused with the culprit named, and a table by trouble: how often home was found,
how far off it was, and how high an arm came above the lower limit.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections import defaultdict
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from tests.rigs.switch_homing import Outcome, draw


def main() -> int:
    """Exit status 1 when a draw did not end as specified."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-n", "--draws", type=int, default=300)
    parser.add_argument("--from", dest="first", type=int, default=0, help="number of the first")
    options = parser.parse_args()
    start_s, bad = time.monotonic(), 0
    by_trouble: dict[str, list[Outcome]] = defaultdict(list)
    with tempfile.TemporaryDirectory(prefix="deltactl-switches-") as folder:
        for number in range(options.first, options.first + options.draws):
            drawn, outcome = draw(number, Path(folder))
            for trouble in drawn.rpartition(", ")[2].split(" and "):
                by_trouble[trouble].append(outcome)
            bad += bool(outcome.problems)
            print(f"\r{number + 1 - options.first} draws", end="", file=sys.stderr, flush=True)
            for problem in outcome.problems:
                print(f"{drawn}: {problem}", flush=True)
    print(f"{'trouble':22}{'draws':>6}{'homed':>6}{'worst home, deg':>17}{'highest arm, deg':>18}")
    for trouble, outcomes in sorted(by_trouble.items()):
        print(_row(trouble, outcomes))
    print(f"{options.draws} draws in {time.monotonic() - start_s:.0f} s: {bad} not as specified")
    return int(bad > 0)


def _row(trouble: str, outcomes: list[Outcome]) -> str:
    homed = [outcome for outcome in outcomes if not outcome.refused]
    worst_deg = max((outcome.home_error_deg for outcome in homed), default=0.0)
    highest_deg = min(outcome.lowest_deg for outcome in outcomes)
    return f"{trouble:22}{len(outcomes):6d}{len(homed):6d}{worst_deg:17.3f}{highest_deg:18.1f}"


if __name__ == "__main__":
    sys.exit(main())
