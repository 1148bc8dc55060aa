"""How often the 95 % intervals of the diagnosis hold the truth, effect by effect.

    python benchmarks/proofs/interval_coverage.py [--seed N] [--rounds N] [--out DIR] [KIND ...]

Draws MuJoCo robots (extra `proof`) with one effect concealed, of moderate size and of a third of
that in turn, and counts for the effects that were named which intervals hold what was built in.
With --out every case is kept and not done again. One round (every kind once) is about 25
intervals and takes two to four minutes of one core.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from deltactl.proof.cases import assemble
from deltactl.proof.hidden.build_in import SINGLES
from deltactl.proof.prove.certainty import wilson
from deltactl.proof.prove.one_case import diagnose_blind
from deltactl.proof.write_case import write_blind

STRENGTHS = (1.0, 1.0 / 3.0)
Interval = tuple[str, float, float, float]
"""Parameter, truth, low, high."""


def intervals(seed: int, kind: str, strength: float) -> list[Interval]:
    """One robot with one effect: all intervals of the finding that names it, if one does."""
    rng = np.random.default_rng([seed, 11, sum(kind.encode())])
    case = assemble(seed, "coverage", [kind], rng, strength=strength)
    with tempfile.TemporaryDirectory(prefix="coverage-") as name:
        write_blind(case, Path(name), seed)
        answer, failure = diagnose_blind(Path(name))
    if answer is None:
        print(f"{kind}: {failure}", file=sys.stderr)
        return []
    truth = case.truth()["answers"][0]
    own = [
        finding
        for finding in answer["findings"]
        if (finding["effect"], finding["component"]) == (truth["effect"], truth["where"])
    ]
    return _compared(truth["parameters"], own[0]["parameters"]) if own else []


def _compared(truths: dict[str, Any], sizes: dict[str, Any]) -> list[Interval]:
    found: list[Interval] = []
    for name, value in truths.items():
        if name not in sizes:
            continue
        limits = np.atleast_2d(sizes[name]["ci95"])
        values = np.atleast_1d(np.asarray(value, dtype=float))
        found += [
            (name, float(v), float(low), float(high))
            for v, (low, high) in zip(values, limits, strict=True)
        ]
    return found


def kept(folder: Path | None, seed: int, kind: str, strength: float) -> list[Interval]:
    """The same, done once and then read."""
    if folder is None:
        return intervals(seed, kind, strength)
    path = folder / f"{kind}-{seed}-{strength:.2f}.json"
    if not path.exists():
        folder.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(intervals(seed, kind, strength)), encoding="utf-8")
    return [(n, v, low, high) for n, v, low, high in json.loads(path.read_text(encoding="utf-8"))]


def line(name: str, hits: list[bool]) -> str:
    """A row of the table."""
    if not hits:
        return f"{name:32s} not named"
    low, high = wilson(sum(hits), len(hits))
    share = 100.0 * float(np.mean(hits))
    limits = f"{100 * low:5.1f} to {100 * high:5.1f} %"
    return f"{name:32s} {sum(hits):4d} of {len(hits):4d} {share:6.1f} %  {limits}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("kinds", nargs="*", default=list(SINGLES))
    parser.add_argument("--seed", type=int, default=9000, help="the first; a round takes one")
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--out", type=Path)
    options = parser.parse_args()
    table: dict[str, list[bool]] = {kind: [] for kind in options.kinds}
    for number in range(options.rounds):
        strength = STRENGTHS[number % len(STRENGTHS)]
        for kind in options.kinds:
            for name, truth, low, high in kept(options.out, options.seed + number, kind, strength):
                held = low <= truth <= high
                table.setdefault(f"  {kind}.{name}", []).append(held)
                table[kind].append(held)
                if not held:
                    print(f"missed: {kind} {name} {truth:.5g} not in [{low:.5g}, {high:.5g}]")
    print(f"{'effect':32s} {'held':>12s}")
    for kind in options.kinds:
        print(line(kind, table[kind]))
    print(line("all", [held for kind in options.kinds for held in table[kind]]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
