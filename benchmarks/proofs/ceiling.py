"""How much of what recordings can tell the diagnosis says, group by group.

    python benchmarks/proofs/ceiling.py OUT [--minutes M] [--missed]

OUT is the folder of a proof (`deltactl prove --out OUT`). Each of its cases with one to five
effects that was not named exactly is simulated again and shown to an observer that is told what
was built in and compares the evidence of the true set with that of its neighbours
(`ideal_observer`): where it would prefer another set, no diagnosis can be expected to name the
true one. What the diagnosis named exactly counts as told, so the observer is not asked there. What
it saw is kept beside the case's result (`ceiling.json`). Five to ten seconds of one core a case,
and the simulation.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

from benchmarks.proofs.ideal_observer import Ceiling, ceiling
from deltactl.diagnosis.estimation.side_by_side import alone
from deltactl.foundation.errors import DeltactlError
from deltactl.proof.cases import MORE, draw, draw_more
from deltactl.proof.prove.certainty import wilson
from deltactl.proof.prove.score import Score, score
from deltactl.proof.write_case import RECORDING, ROBOT_FILE, write_blind

GROUPS = ("single", "faint", "two", "three", "four", "five")
"""Groups of cases in which effects of the vocabulary were concealed, and nothing else."""
KEPT = "ceiling.json"


def observed(result: dict[str, Any], marks: Score, kept: Path) -> Ceiling:
    """What the observer sees of one case, from its file where it has looked before."""
    if kept.exists():
        return Ceiling(**json.loads(kept.read_text(encoding="utf-8")))
    seed, number = int(result["seed"]), int(marks.case.rpartition("_")[2])
    case = (draw_more if marks.case.startswith(MORE) else draw)(seed, number)
    with tempfile.TemporaryDirectory(prefix="ceiling-") as name, alone():
        folder = Path(name)
        write_blind(case, folder, seed)
        seen = ceiling(folder / RECORDING, folder / ROBOT_FILE, marks.truth, marks.said)
    kept.write_text(json.dumps(asdict(seen)) + "\n", encoding="utf-8")
    return seen


def cases(out: Path) -> Iterator[tuple[dict[str, Any], Score, Path]]:
    """Results of a proof that were answered, of the groups above."""
    for file in sorted(out.glob("*/result.json")):
        result = json.loads(file.read_text(encoding="utf-8"))
        if "diagnosis" not in result:  # a tie
            continue
        marks = score(result)
        if marks.group in GROUPS and marks.failure is None:
            yield result, marks, file.with_name(KEPT)


def share(of: list[Score]) -> str:
    """How many are exact, with its 95 % limits."""
    if not of:
        return "-"
    right = sum(marks.exact for marks in of)
    low, high = wilson(right, len(of))
    return (
        f"{right} of {len(of)}, {100 * right / len(of):.1f} % [{100 * low:.0f}, {100 * high:.0f}]"
    )


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("out", type=Path)
    parser.add_argument("--minutes", type=float, default=float("inf"))
    parser.add_argument("--missed", action="store_true", help="list what the observer would tell")
    options = parser.parse_args()
    until = time.monotonic() + 60.0 * options.minutes
    seen: list[tuple[Score, str]] = []
    """What was answered, and what speaks against the truth: empty where the recording tells it."""
    for result, marks, kept in cases(options.out):
        if marks.exact:
            seen.append((marks, ""))
            continue
        if time.monotonic() > until:
            print(f"stopped after {options.minutes:g} minutes; the same command goes on")
            break
        try:
            seen.append((marks, observed(result, marks, kept).against))
        except DeltactlError as error:
            print(f"{marks.case}: {error}", file=sys.stderr)
    print("| group | named exactly, of all | the recording tells | named exactly, of these |")
    print("|---|---|---|---|")
    for group in (*GROUPS, ""):
        own = [pair for pair in seen if pair[0].group == group or not group]
        told = [marks for marks, why in own if not why]
        if own:
            all_ = share([marks for marks, _ in own])
            print(f"| {group or 'all'} | {all_} | {len(told)} | {share(told)} |")
    reasons = Counter(_kind(why) for _, why in seen if why)
    print("\n".join(f"{count} x {reason}" for reason, count in reasons.most_common()))
    if options.missed:
        for marks, why in seen:
            if not marks.exact:
                print(f"{marks.case}: {marks.truth} said {marks.said}: {why or 'tells'}")
    return 0


def _kind(why: str) -> str:
    """A reason without its names."""
    for kind in ("too faint", "is like", "beside it"):
        if kind in why:
            return kind
    return why


if __name__ == "__main__":
    sys.exit(main())
