"""How often a healthy lone machine is said to miss something, on rigs of other code.

    python -m benchmarks.proofs.axis_false_alarms [--cases 100] [--seed 1] [--kinds "range sensor"]

Axes with commands (fine and coarse encoder, log in counts, stepper), with effort, and range
sensors, 15 to 60 s long, noise with a correlation of 0 to 0.9 from sample to sample
(tests/axes/axis_rigs.py).
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from multiprocessing import get_context

import numpy as np

from deltactl.diagnosis.answer.records import Diagnosis
from deltactl.diagnosis.api import diagnose_recordings
from deltactl.models.robot import Drive, RangeSensor, ServoAxis, StepperAxis
from tests.axes.axis_rigs import FollowingRig, ForcedRig, RangingRig

FOLLOWS = ServoAxis(kind="servo_axis", name="follows", motion="rotary")
FORCED = ServoAxis(kind="servo_axis", name="forced", motion="linear", inertia=2.0)
STEPS = StepperAxis(
    kind="stepper_axis", name="steps", drive=Drive(microsteps_per_rev=1600, gear_ratio=10)
)
RANGES = RangeSensor(kind="range_sensor", name="ranges")
COUNT_RAD = 1.5e-3
Run = Callable[[int, float, float], Diagnosis]


def _in_counts(seed: int, span_s: float, rho: float) -> Diagnosis:
    """A drive whose log has command and reading in counts of its encoder; noise of half a count."""
    rig = FollowingRig(rho=rho, noise=0.5 * COUNT_RAD, encoder_step=COUNT_RAD)
    log = rig.record(seed, span_s=span_s)
    command = COUNT_RAD * np.round(log.columns["command"] / COUNT_RAD)
    rounded = replace(log, columns={**log.columns, "command": command})
    return diagnose_recordings(FOLLOWS, [rounded])


KINDS: dict[str, Run] = {
    "commands": lambda seed, s, rho: diagnose_recordings(
        FOLLOWS, [FollowingRig(rho=rho).record(seed, span_s=s)]
    ),
    "coarse encoder": lambda seed, s, rho: diagnose_recordings(
        FOLLOWS, [FollowingRig(rho=rho, noise=1e-4, encoder_step=1.5e-3).record(seed, span_s=s)]
    ),
    "log in counts": _in_counts,
    "stepper": lambda seed, s, rho: diagnose_recordings(
        STEPS, [FollowingRig(rho=rho).record(seed, span_s=s, names="command_1 theta_1")]
    ),
    "range sensor": lambda seed, s, rho: diagnose_recordings(
        RANGES, [RangingRig(rho=rho).record(seed, span_s=s)]
    ),
    "effort": lambda seed, s, rho: diagnose_recordings(
        FORCED, [ForcedRig(rho=0.5 * rho).record(seed, span_s=min(s, 20.0))]
    ),
}


def one(kinds: Sequence[str], seed: int, number: int) -> tuple[str, str, list[str], float]:
    """Kind, verdict, findings and probability of nothing missing, of one healthy machine."""
    rng = np.random.default_rng([seed, number])
    name = kinds[number % len(kinds)]
    span_s, rho = float(rng.choice([15.0, 30.0, 60.0])), float(rng.choice([0.0, 0.3, 0.7, 0.9]))
    answer = KINDS[name](int(rng.integers(2**31)), span_s, rho)
    found = [f"{f.effect} {f.probability or 0.0:.2f}" for f in answer.findings]
    return name, answer.verdict, found, answer.probability_nothing_missing or 0.0


def main() -> None:
    """Print a row a kind of machine."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--cases", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kinds", default=",".join(KINDS), help="kinds of machine, by commas")
    options = parser.parse_args()
    kinds = options.kinds.split(",")
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        rows = list(pool.map(partial(one, kinds, options.seed), range(options.cases)))
    print(f"{'machine':16} healthy  with findings  unsure  least probability of nothing missing")
    for name in kinds:
        own = [row for row in rows if row[0] == name]
        claimed = [row for row in own if row[2]]
        unsure = [row for row in own if not row[2] and row[1] != "nothing_missing"]
        least = min((row[3] for row in own), default=float("nan"))
        print(f"{name:16} {len(own):7} {len(claimed):14} {len(unsure):7}  {least:.3f}")
    for name, verdict, found, nothing in rows:
        if found:
            print(f"    {name}: {verdict}, {', '.join(found)} (nothing {nothing:.3f})")


if __name__ == "__main__":
    main()
