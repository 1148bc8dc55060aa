"""Whether an effect of the smallest detectable size raises the alarm in four recordings of five.

    python benchmarks/proofs/detection_limit.py [--rounds N] [--seed N] [--seconds S] [KIND ...]

For each kind: diagnoses a MuJoCo robot (extra `proof`) with nothing hidden, takes the smallest
size that the answer says raises the alarm, builds just that size into the robot, records it anew
with other noise, and counts how often the alarm is raised, and how often the effect is a finding or
an alternative of one. One row takes about half a minute.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from deltactl.models.effects import effect_kind
from deltactl.proof.cases import Case, assemble, write_blind
from deltactl.proof.prove.one_case import diagnose_blind
from deltactl.proof.prove.reliability import wilson

OF_SHAPE = ("home_offset", "gear_ratio", "sensor_offset", "sensor_scale", "forearm_length")
KINDS = (*OF_SHAPE, "sensor_latency", "joint_friction", "joint_compliance")
POWER = 0.8


def case_of(seed: int, kind: str, seconds: float, strength: float = 1.0) -> Case:
    """The robot of a seed with a kind of that strength; motion and noise level are the same."""
    rng = np.random.default_rng([seed, sum(kind.encode())])
    return assemble(seed, "limit", [kind], rng, "survey", seconds, strength)


def answered(case: Case, seed: int) -> dict[str, Any]:
    """The answer of the engine. Raises RuntimeError with what went wrong."""
    with tempfile.TemporaryDirectory(prefix="limit-") as folder:
        write_blind(case, Path(folder), seed)
        answer, failure = diagnose_blind(Path(folder))
    if answer is None:
        raise RuntimeError(failure)
    return answer


def strength_of(case: Case, smallest: float) -> float:
    """How many times what was drawn amounts to a size."""
    part = case.planned[0]
    drawn = float(np.atleast_1d(part.parameters[part.kind.main])[0])
    if effect_kind(part.kind.effect).nothing == 1.0:
        return abs(smallest / (drawn - 1.0))
    # A stiffness is drawn as one over the strength: both sizes act by their reciprocal.
    return abs(drawn / smallest if part.kind.main == "stiffness" else smallest / drawn)


def found(seed: int, kind: str, seconds: float) -> tuple[bool, bool] | None:
    """Alarm raised, and effect offered; None where the answer names no smallest size."""
    drawn = case_of(seed, kind, seconds)
    part = drawn.planned[0]
    nearly_none = answered(case_of(seed, kind, seconds, 1e-6), seed)
    named = [
        smallest["value"]
        for smallest in nearly_none["smallest_detectable"]
        if (smallest["effect"], smallest["component"]) == (kind, part.component)
    ]
    if not named:
        return None
    answer = answered(case_of(seed, kind, seconds, strength_of(drawn, named[0])), seed + 1_000_003)
    offered = {
        (offer["effect"], offer["component"])
        for finding in answer["findings"]
        for offer in (finding, *finding["alternatives"])
    }
    return answer["verdict"] != "nothing_missing", (kind, part.component) in offered


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("kinds", nargs="*", default=list(KINDS))
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=60.0)
    options = parser.parse_args()
    rows: dict[str, list[tuple[bool, bool]]] = defaultdict(list)
    for number in range(options.rounds):
        for kind in options.kinds:
            marks = found(options.seed + number, kind, options.seconds)
            if marks is not None:
                rows[kind].append(marks)
    every = [marks for each in rows.values() for marks in each]
    print(f"{'effect':20s} {'cases':>5s} {'alarm':>6s} {'offered':>8s}")
    for kind, each in {**rows, "all": every}.items():
        alarms, offers = (sum(column) for column in zip(*each, strict=True))
        print(f"{kind:20s} {len(each):5d} {alarms:6d} {offers:8d}")
    low, high = wilson(sum(alarm for alarm, _ in every), len(every))
    print(f"alarm in {low:.0%} to {high:.0%} (95 % limits); wanted {POWER:.0%}")


if __name__ == "__main__":
    main()
