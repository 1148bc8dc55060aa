"""Arms and gantries in motion with hidden faults: what is named of how many, and how well sized.

    python -m benchmarks.proofs.moving_arms --cases 40 --seed 2 [--gantries 20]
        [--as-built] [--counts 2048]

Even seeds are for tuning, odd ones for judging. Needs Pinocchio (`pip install pin`), which is no
dependency of the package. The diagnosis reads the table, the robot file and the URDF, no more.

A case is right where exactly what is hidden is named at its joint, each by its name or as the first
alternative of a finding. A lag is right where no time constant is claimed of a dead time, and no
dead time of a time constant: the interval of that size reaches zero. An unknown is right where
something unknown is said of its joint and no other joint is accused.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import resource
import tempfile
import time
from collections import defaultdict
from pathlib import Path

import numpy as np

from benchmarks.proofs.drawn_arms import ALONE, Draw, Fault, Kind, drawn
from benchmarks.proofs.measured_poses import Expected, held, named
from deltactl.cli.recordings.init_chain import chain
from deltactl.diagnosis.answer.records import Diagnosis
from deltactl.diagnosis.api import diagnose
from deltactl.models.effects.chain_joints import JOINT_EFFECTS, LOAD

LAGS = ("time", "dead_time")
NONE_S = 1e-4
"""Lag that is none."""


def expected(faults: list[Fault]) -> list[Expected]:
    """Faults by the names of their effects and sizes."""
    names = {key: (one.name, one.parameter) for key, one in JOINT_EFFECTS.items()}
    names |= {"load": (LOAD, "mass")}
    names |= {size: (JOINT_EFFECTS["lag"].name, size) for size in LAGS}
    return [(names[key][0], at, names[key][1], size) for key, at, size in faults]


def lags_as_hidden(answer: Diagnosis, hidden: list[Expected]) -> bool:
    """Whether each named lag may be all of the size that is hidden."""
    of_joint = {at: size for _, at, size, _ in hidden if size in LAGS}
    lag = JOINT_EFFECTS["lag"].name
    return all(
        one.parameters[name].components[0][1] <= NONE_S
        for one in answer.findings
        if one.effect == lag and one.component in of_joint
        for name in LAGS
        if name in one.parameters and name != of_joint[one.component]
    )


def right_about_unknown(answer: Diagnosis, joint: str) -> bool:
    """Whether an unknown is seen at its joint, and no other joint is accused."""
    seen = any((f.effect, f.component) == ("unknown", joint) for f in answer.findings)
    return seen and all(f.component == joint for f in answer.findings)


def _case(
    folder: Path, seed: int, number: int, gantry: bool, kind: Kind
) -> tuple[str, Draw, str, Diagnosis]:
    file = folder / f"{'gantry' if gantry else 'arm'}{number}.csv"
    tier, draw, joint = drawn(seed, number, gantry, file, kind=kind)
    robot = file.with_suffix(".yaml")
    with contextlib.redirect_stdout(io.StringIO()):
        chain(robot, file.with_suffix(".urdf"))
    return tier, draw, joint, diagnose([file], robot)


def _shown(answer: Diagnosis, draw: Draw) -> None:
    """What is hidden, and what was found."""
    for effect, at, parameter, size in expected(draw.expected):
        print(f"    hidden: {effect} {at} {parameter} {size:.4g}")
    for f in answer.findings:
        others = "; ".join(f"{a.effect} {a.component}" for a in f.alternatives[:2])
        sizes = {
            name: " ".join(f"{x:.4g}" for x in one.components[0])
            for name, one in list(f.parameters.items())[:2]
        }
        print(f"    found: {f.effect} {f.component} {f.probability or 0.0:.2f} {sizes} {others}")


def main() -> None:
    """Print each case that is not right or not well sized, and the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=40, help="arms")
    parser.add_argument("--gantries", type=int, default=0)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--fault", default="", choices=sorted(ALONE), help="hide this one in each")
    parser.add_argument("--as-built", action="store_true", help="with all tolerances of a machine")
    parser.add_argument("--counts", type=int, default=0, help="of an encoder, to one side")
    asked = parser.parse_args()
    kind = Kind(asked.fault, asked.as_built, asked.counts)
    right: dict[str, list[bool]] = defaultdict(list)
    intervals: list[bool] = []
    seconds: list[float] = []
    cases = [(number, False) for number in range(asked.first, asked.first + asked.cases)]
    cases += [(number, True) for number in range(asked.first, asked.first + asked.gantries)]
    with tempfile.TemporaryDirectory() as name:
        for number, gantry in cases:
            begun = time.process_time()
            tier, draw, joint, answer = _case(Path(name), asked.seed, number, gantry, kind)
            seconds.append(time.process_time() - begun)
            found, wrong = named(answer, expected(draw.expected))
            good = found == len(draw.expected) and not wrong
            good &= lags_as_hidden(answer, expected(draw.expected))
            if joint:
                good = right_about_unknown(answer, joint)
            machine = "gantry" if gantry else "arm"
            right[f"{machine}, {tier}"].append(good)
            within = held(answer, expected(draw.expected))
            intervals += within
            if not good or not all(within):
                result = "right" if good else "WRONG"
                print(machine, number, tier, f"{seconds[-1]:.1f} s", result, answer.verdict, joint)
                _shown(answer, draw)
    print(f"\n{'machines':20} right   of")
    for machines, results in sorted(right.items()):
        print(f"{machines:20} {sum(results):5} {len(results):4}")
    print(f"95 % intervals that hold the truth: {sum(intervals)} of {len(intervals)}")
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
    print(
        f"seconds of one core a case with its simulation: median {np.median(seconds):.1f},"
        f" most {max(seconds):.1f}; peak memory {peak} MB"
    )


if __name__ == "__main__":
    main()
