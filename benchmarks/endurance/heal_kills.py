"""Healings interrupted at random moments: python -m benchmarks.endurance.heal_kills [-n 50].

The client, the daemon or all processes are killed, somebody stops the robot, a drive fails, or
the sensors go blind, in real time on the simulated robot. Prints a line for each, a table, and
exit status 1 where the old robot file was not in force or the robot not at rest afterwards.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path
from random import Random

from tests.rigs.faults.heal_kills import KINDS, HealStand, Interrupted, campaign, lasting_s, table


def main() -> int:
    """Exit status 1 when an interruption was not borne."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-n", "--interruptions", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--minutes", type=float, default=0.3, help="length of the survey")
    given = parser.parse_args()
    rows: list[Interrupted] = []
    begun_s = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="deltactl-heal-") as place:
        stand = HealStand(Path(place), given.minutes)
        try:
            lasts_s = lasting_s(stand)
            print(f"a healing takes {lasts_s:.0f} s", flush=True)
            chance = Random(given.seed)
            for row in campaign(stand, given.interruptions, chance, KINDS, lasts_s):
                rows.append(row)
                said = "; ".join(row.problems) or "as it has to be"
                step = row.step or "nothing yet"
                print(
                    f"{len(rows):3d} {row.kind:16} {row.after_s:5.1f} s, after: {step}: {said}",
                    flush=True,
                )
        finally:
            stand.close()
    print("\n".join(table(rows)))
    print(f"{time.monotonic() - begun_s:.0f} s")
    return int(any(row.problems for row in rows))


if __name__ == "__main__":
    sys.exit(main())
