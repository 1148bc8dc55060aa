"""How fast the daemon answers while it works on large files: benchmarks/endurance/answers.py.

Prints, for files of each kind that hold up whoever reads them, the time to the answer, and the
longest time to the answer of a `status`, a `stop` and an `acknowledge` meanwhile. A job that takes
long is answered with 'planning', and followed.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from tests.rigs.large_requests import MB, Latencies, daemon, files, measured

MOST_ANSWER_S = 2.0
MOST_MEANWHILE_S = 0.2
ASKED = ("status", "stop", "acknowledge")


def main() -> int:
    """Exit status 1 when an answer was late."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--megabytes", type=float, default=4.0)
    parser.add_argument("--kind", default="", help="only kinds whose name holds this")
    options = parser.parse_args()
    late = 0
    print(f"{'seconds':36s}{'answer':>8s}" + "".join(f"{name:>13s}" for name in ASKED))
    with tempfile.TemporaryDirectory() as folder, daemon(Path(folder)) as socket:
        for name, do, path in files(Path(folder), round(options.megabytes * MB)):
            if options.kind in name:
                found = measured(socket, do, path)
                late += _is_late(found)
                times = "".join(f"{found.meanwhile_s.get(request, 0.0):13.3f}" for request in ASKED)
                says = "planning " if found.planned_late else ""
                says += "late" if _is_late(found) else ""
                print(f"{do + ': ' + name:36s}{found.answer_s:8.2f}{times} {says}", flush=True)
    print(f"{late} late")
    return int(late > 0)


def _is_late(found: Latencies) -> bool:
    worst_s = max(found.meanwhile_s.values(), default=0.0)
    return found.answer_s > MOST_ANSWER_S or worst_s > MOST_MEANWHILE_S


if __name__ == "__main__":
    sys.exit(main())
