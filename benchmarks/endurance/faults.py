"""Fault campaign on the simulated robot in real time: benchmarks/endurance/faults.py [-n 500].

Daemon parts, pulse process, sensors, drives, disk and clients are made to fail at random moments
of a run; prints the worst figures of each kind of fault, and whatever was not as specified. What
failed while the machine had no core for the robot is tried again, three times at most.
"""

from __future__ import annotations

import argparse
import itertools
import sys
import time
from functools import partial
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from tests.rigs.faults.campaign import (
    BESIDE_KINDS,
    KINDS,
    campaign,
    daemon_campaign,
    once_more,
    rest_campaign,
    settled,
    table,
)
from tests.rigs.faults.verdict import Verdict


def _print_problems(number: int, verdict: Verdict) -> None:
    for problem in verdict.problems:
        waited = f"(waited {verdict.waited_s:.2f} s for a core)"
        print(f"{number:4d} {verdict.kind}: {problem} {waited}", flush=True)


def main() -> int:
    """Exit status 1 when a fault was not handled as specified."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-n", "--faults", type=int, default=500)
    parser.add_argument("-d", "--daemons", type=int, default=40, help="faults of the daemon")
    parser.add_argument("-r", "--rest", type=int, default=160, help="faults beside a run")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kind", action="append", help="only kinds whose name holds this")
    options = parser.parse_args()

    def wanted(name: str) -> bool:
        return any(part in name for part in options.kind or [""])

    kinds = [kind for kind in KINDS if wanted(kind.name)]
    verdicts: list[Verdict] = []
    start_s = time.monotonic()
    rest = {name: kind for name, kind in BESIDE_KINDS.items() if wanted(name)}
    parts = (
        campaign(options.faults, options.seed, kinds) if kinds else iter(()),
        rest_campaign(options.rest, options.seed, rest) if rest else iter(()),
        daemon_campaign(options.daemons, options.seed),
    )
    for verdict in itertools.chain(*parts):
        verdicts.append(verdict)
        _print_problems(len(verdicts), verdict)
    busy = sum(bool(verdict.problems) and not verdict.counts for verdict in verdicts)
    verdicts = [settled(partial(once_more, verdict.kind), verdict) for verdict in verdicts]
    print(f"{busy} tried again, because the machine had no core for the robot")
    kinds_tried, took_s = len({verdict.kind for verdict in verdicts}), time.monotonic() - start_s
    print(f"{len(verdicts)} faults of {kinds_tried} kinds in {took_s:.0f} s")
    print("\n".join(table(verdicts)))
    return int(any(verdict.problems for verdict in verdicts))


if __name__ == "__main__":
    sys.exit(main())
