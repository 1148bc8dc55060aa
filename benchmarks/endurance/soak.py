"""Soak: python benchmarks/endurance/soak.py [--hours 24] or [--real-minutes 20].

--hours: simulated running on the virtual clock, job after job through the daemon's table of
requests, with homing, pauses, cancelled jobs, breaks and `verify`; the step watch looks on.
--real-minutes: a daemon of its own in real time, with its pulse process, over its socket.
Prints worst figures and slopes of memory, open files, threads, counters and recordings.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from benchmarks.endurance.soak_real import soak_real
from benchmarks.endurance.soak_virtual import soak_virtual


def main() -> int:
    """Exit status 1 when something grew, drifted, was lost or was reported falsely."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--hours", type=float, default=24.0, help="of virtual running")
    parser.add_argument("--real-minutes", type=float, help="run a daemon in real time instead")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--folder", type=Path, help="for recordings; a small disk is a good one")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="deltactl-soak-") as scratch:
        folder = options.folder or Path(scratch)
        if options.real_minutes:
            return soak_real(options.real_minutes, folder)
        return soak_virtual(options.hours, folder, options.seed)


if __name__ == "__main__":
    sys.exit(main())
