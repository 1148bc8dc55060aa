"""Arms and gantries in motion with hidden faults: what is named of how many, and how well sized.

    python -m benchmarks.proofs.moving_arms --cases 40 --seed 2 [--gantries 20]

Even seeds are for tuning, odd ones for judging. Needs Pinocchio (`pip install pin`), which is no
dependency of the package. The diagnosis reads the table, the robot file and the URDF, no more.

A case is right where exactly what is hidden is named at its joint, each by its name or as the first
alternative of a finding. An unknown is right where something unknown is said of its joint and no
other joint is accused.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import resource
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks.proofs.measured_poses import Expected, held, named
from benchmarks.proofs.moving_machines import (
    Faults,
    Machine,
    Moved,
    fourier,
    machine,
    recorded,
    rigid,
    trapezoids,
)
from deltactl.cli.recordings.init_chain import chain
from deltactl.diagnosis.answer.records import Diagnosis
from deltactl.diagnosis.api import diagnose
from deltactl.models.effects.chain_joints import JOINT_EFFECTS, LOAD
from deltactl.models.robot import FloatArray

Rng = np.random.Generator
SECONDS = 60.0
TIERS = ("none", "single", "pair", "unknown")
BEYOND_STATED = 0.2
"""Share of the stated friction by which a fault's is larger: by half as much two days differ."""
OF_FOUR = (0, 1, 1, 1, 2, 2, 2, 3)
"""Tiers in turn: one healthy machine in eight, three with one fault, three with two."""


class Draw:
    """What is drawn for one machine: how large a fault usually is at each joint."""

    def __init__(self, rng: Rng, own: Machine, moved: Moved):
        self.rng, self.own, self.moved = rng, own, moved
        self.faults = Faults(len(own.joints))
        bare = rigid(own, _every(moved, 50), self.faults, np.zeros(len(own.joints)))
        needed = bare + np.sign(_every(moved, 50).speed) * own.dry
        self.effort: FloatArray = np.sqrt(np.mean(needed**2, axis=0))
        """Of each joint, by its root mean square."""
        self.expected: list[Expected] = []

    def joint(self) -> int:
        """Any."""
        return int(self.rng.integers(len(self.own.joints)))

    def share(self, low: float = 0.06, high: float = 0.4) -> float:
        """Of the usual effort."""
        return float(np.exp(self.rng.uniform(np.log(low), np.log(high))))

    def beside(self, stated: float, size: float) -> float:
        """A size beyond that by which friction differs from what the drawing states."""
        return max(size, BEYOND_STATED * stated)

    def expects(self, key: str, joint: int, size: float) -> None:
        """One fault at a joint."""
        one = JOINT_EFFECTS[key]
        self.expected.append((one.name, self.own.joints[joint], one.parameter, float(size)))


def _every(moved: Moved, rows: int) -> Moved:
    each = (moved.t_s, moved.at, moved.speed, moved.change)
    return Moved(*(values[::rows] for values in each))


def _dry(draw: Draw) -> None:
    j = draw.joint()
    draw.faults.dry[j] = draw.beside(draw.own.dry[j], draw.share() * draw.effort[j])
    draw.expects("dry", j, draw.faults.dry[j])


def _viscous(draw: Draw) -> None:
    j = draw.joint()
    top = np.quantile(np.abs(draw.moved.speed[:, j]), 0.95)
    size = 1.5 * draw.share() * draw.effort[j] / top
    draw.faults.viscous[j] = draw.beside(draw.own.viscous[j], size)
    draw.expects("viscous", j, draw.faults.viscous[j])


def _rotor(draw: Draw) -> None:
    j = draw.joint()
    while draw.own.slides and draw.faults.gain[j] != 1.0:
        j = draw.joint()
    draw.faults.rotor[j] = draw.share() * draw.effort[j] / np.std(draw.moved.change[:, j])
    draw.expects("rotor", j, draw.faults.rotor[j])


def _offset(draw: Draw) -> None:
    j = draw.joint()
    draw.faults.offset[j] = draw.rng.choice([-1.0, 1.0]) * draw.share() * draw.effort[j]
    draw.expects("offset", j, draw.faults.offset[j])


def _gain(draw: Draw) -> None:
    j = draw.joint()
    while draw.own.slides and draw.faults.rotor[j]:  # on a level slide both are one
        j = draw.joint()
    draw.faults.gain[j] = np.exp(draw.rng.choice([-1.0, 1.0]) * draw.rng.uniform(0.1, 0.25))
    draw.expects("gain", j, draw.faults.gain[j])


def _lag(draw: Draw) -> None:
    j = draw.joint()
    draw.faults.dead_s[j] = np.exp(draw.rng.uniform(np.log(0.008), np.log(0.06)))
    draw.expects("lag", j, draw.faults.dead_s[j])


def _load(draw: Draw) -> None:
    own, faults = draw.own, draw.faults
    faults.load_kg = draw.share(0.03, 0.15) * float(own.masses.sum())
    faults.load_at_m = draw.rng.uniform(-0.1, 0.1, 3)
    draw.expected.append((LOAD, own.tip, "mass", faults.load_kg))


NAMED: tuple[Callable[[Draw], None], ...] = (_dry, _viscous, _rotor, _offset, _gain, _lag, _load)


def _coupled(draw: Draw) -> int:
    """One joint's drive turns another joint too."""
    j = draw.joint()
    other = (j + 1) % len(draw.own.joints)
    draw.faults.coupled[j, other] = draw.share(0.15, 0.4) * draw.effort[j] / draw.effort[other]
    return j


def _drifts(draw: Draw) -> int:
    """A torque constant that changes as a motor warms up."""
    j = draw.joint()
    draw.faults.drift[j] = -draw.share(0.1, 0.35)
    return j


def _by_place(draw: Draw) -> int:
    """Friction that grows along the way."""
    j = draw.joint()
    draw.faults.dry[j] = draw.share(0.15, 0.4) * draw.effort[j]
    draw.faults.by_place[j] = draw.rng.choice([-0.8, 0.8])
    return j


UNKNOWN: tuple[Callable[[Draw], int], ...] = (_coupled, _drifts, _by_place)


def drawn(seed: int, number: int, gantry: bool, file: Path) -> tuple[str, Draw, str]:
    """Machine `number` of a seed: its tier and faults, and the joint of what has no name."""
    rng = np.random.default_rng([seed, number, int(gantry)])
    own = machine(rng, gantry)
    moved = (fourier if rng.integers(0, 2) else trapezoids)(rng, own, SECONDS)
    draw, tier, joint = Draw(rng, own, moved), TIERS[OF_FOUR[number % len(OF_FOUR)]], ""
    if tier == "unknown":
        joint = own.joints[UNKNOWN[number // len(OF_FOUR) % len(UNKNOWN)](draw)]
    else:
        for which in rng.choice(len(NAMED), TIERS.index(tier), replace=False):
            NAMED[int(which)](draw)
    file.with_suffix(".urdf").write_text(own.urdf())
    recorded(file, own, draw.faults, rng, moved, SECONDS)
    return tier, draw, joint


def right_about_unknown(answer: Diagnosis, joint: str) -> bool:
    """Whether an unknown is seen at its joint, and no other joint is accused."""
    seen = any((f.effect, f.component) == ("unknown", joint) for f in answer.findings)
    return seen and all(f.component == joint for f in answer.findings)


def _case(folder: Path, seed: int, number: int, gantry: bool) -> tuple[str, Draw, str, Diagnosis]:
    file = folder / f"{'gantry' if gantry else 'arm'}{number}.csv"
    tier, draw, joint = drawn(seed, number, gantry, file)
    robot = file.with_suffix(".yaml")
    with contextlib.redirect_stdout(io.StringIO()):
        chain(robot, file.with_suffix(".urdf"))
    return tier, draw, joint, diagnose([file], robot)


def _shown(answer: Diagnosis, draw: Draw) -> None:
    """What is hidden, and what was found."""
    for effect, at, parameter, size in draw.expected:
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
    asked = parser.parse_args()
    right: dict[str, list[bool]] = defaultdict(list)
    intervals: list[bool] = []
    seconds: list[float] = []
    cases = [(number, False) for number in range(asked.first, asked.first + asked.cases)]
    cases += [(number, True) for number in range(asked.first, asked.first + asked.gantries)]
    with tempfile.TemporaryDirectory() as name:
        for number, gantry in cases:
            begun = time.process_time()
            tier, draw, joint, answer = _case(Path(name), asked.seed, number, gantry)
            seconds.append(time.process_time() - begun)
            found, wrong = named(answer, draw.expected)
            good = found == len(draw.expected) and not wrong
            if tier == "unknown":
                good = right_about_unknown(answer, joint)
            kind = "gantry" if gantry else "arm"
            right[f"{kind}, {tier}"].append(good)
            within = held(answer, draw.expected)
            intervals += within
            if not good or not all(within):
                result = "right" if good else "WRONG"
                print(kind, number, tier, f"{seconds[-1]:.1f} s", result, answer.verdict, joint)
                _shown(answer, draw)
    print(f"\n{'machines':20} right   of")
    for kind, results in sorted(right.items()):
        print(f"{kind:20} {sum(results):5} {len(results):4}")
    print(f"95 % intervals that hold the truth: {sum(intervals)} of {len(intervals)}")
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
    print(
        f"seconds of one core a case with its simulation: median {np.median(seconds):.1f},"
        f" most {max(seconds):.1f}; peak memory {peak} MB"
    )


if __name__ == "__main__":
    main()
