"""Arms with hidden faults by their poses: what is named of how many draws, and how sizes are held.

    python benchmarks/proofs/measured_poses.py SEED [--arms 60] [--odd]

Even draws are for tuning, odd ones (`--odd`) for judging. A draw is right where exactly the hidden
effects are named, each by its name or as its first alternative.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks.proofs.measured_arm import JOINTS, Hidden, measured, table, urdf_text
from deltactl.cli.recordings.init_chain import chain
from deltactl.diagnosis.answer.records import Diagnosis
from deltactl.diagnosis.api import diagnose
from deltactl.models.effects.chain_poses import POSE_EFFECTS

Rng = np.random.Generator
Expected = tuple[str, str, str, float]
"""Effect (by its column while it is drawn), component, parameter, size."""
LENGTHS = ((1, 0), (2, 2), (3, 2), (3, 0))
"""Joint and direction of lengths that no zero makes up for."""


def _zero(hidden: Hidden, rng: Rng) -> Expected:
    joint = int(rng.integers(1, 5))
    hidden.home_rad[joint] = _signed(rng, 1e-3, 2e-2)
    return "home", JOINTS[joint], "angle", hidden.home_rad[joint]


def _length(hidden: Hidden, rng: Rng) -> Expected:
    joint, axis = LENGTHS[int(rng.integers(len(LENGTHS)))]
    hidden.off[joint, axis] = _signed(rng, 2e-4, 3e-3)
    return "geometry", JOINTS[joint], f"d{'xyz'[axis]}", hidden.off[joint, axis]


def _yielding(hidden: Hidden, rng: Rng) -> Expected:
    joint = int(rng.integers(1, 3))
    hidden.compliance[joint] = abs(_signed(rng, 3e-6, 4e-5))
    return "droop", JOINTS[joint], "stiffness", 1.0 / hidden.compliance[joint]


def _wave(hidden: Hidden, rng: Rng) -> Expected:
    joint = int(rng.integers(0, 5))
    hidden.wave_rad[joint] = abs(_signed(rng, 1e-4, 1e-3))
    hidden.waves[joint] = rng.choice([1, 2, 100])
    return "wave", JOINTS[joint], "amplitude", hidden.wave_rad[joint]


def _play(hidden: Hidden, rng: Rng) -> Expected:
    joint = int(rng.integers(0, 5))
    hidden.play_rad[joint] = abs(_signed(rng, 1e-4, 2e-3))
    return "play", JOINTS[joint], "width", hidden.play_rad[joint]


def _windup(hidden: Hidden, rng: Rng) -> Expected:
    joint = int(rng.integers(0, 5))
    hidden.ahead_rad, hidden.windup[joint] = 5e-4, _signed(rng, 0.2, 1.0)
    return "windup", JOINTS[joint], "share", hidden.windup[joint]


def _unsettled(hidden: Hidden, rng: Rng) -> Expected:
    hidden.missing = abs(_signed(rng, 2e-4, 5e-3))
    return "rest", "sensors", "share_of_last_move", hidden.missing


FAULTS: tuple[Callable[[Hidden, Rng], Expected], ...] = (
    _zero,
    _length,
    _yielding,
    _wave,
    _play,
    _windup,
    _unsettled,
)


def _signed(rng: Rng, low: float, high: float) -> float:
    return float(rng.choice([-1.0, 1.0]) * np.exp(rng.uniform(np.log(low), np.log(high))))


def drawn(seed: int, number: int) -> tuple[Hidden, list[Expected], int]:
    """Arm `number` of a seed, what is hidden in it, and in how many poses it is seen."""
    rng = np.random.default_rng([seed, number])
    hidden = Hidden(noise_m=float(np.exp(rng.uniform(np.log(1e-5), np.log(6e-5)))))
    count = number // 2 % 3  # none, one, two
    chosen = rng.choice(len(FAULTS), count, replace=False)
    expected = [FAULTS[int(which)](hidden, rng) for which in chosen]
    expected = [(POSE_EFFECTS[k].name, joint, name, size) for k, joint, name, size in expected]
    return hidden, expected, int(rng.choice([60, 120, 250]))


def named(answer: Diagnosis, expected: list[Expected]) -> tuple[int, int]:
    """How many of what is hidden are named, and how many findings are none of it."""
    wanted = {(effect, joint) for effect, joint, *_ in expected}
    found = [
        {(f.effect, f.component), *((a.effect, a.component) for a in f.alternatives[:1])}
        for f in answer.findings
    ]
    return sum(any(w in f for f in found) for w in wanted), sum(not f & wanted for f in found)


def held(answer: Diagnosis, expected: list[Expected]) -> list[bool]:
    """Whether each interval of what was named holds the truth."""
    within = []
    for effect, joint, parameter, truth in expected:
        for one in answer.findings:
            if (one.effect, one.component) == (effect, joint) and parameter in one.parameters:
                _, low, high = one.parameters[parameter].components[0]
                within.append(low <= truth <= high)
    return within


def main() -> None:
    """Print a line for each draw that is not right, and the shares."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("seed", type=int)
    parser.add_argument("--arms", type=int, default=60)
    parser.add_argument("--odd", action="store_true")
    asked = parser.parse_args()
    right: dict[int, list[bool]] = {0: [], 1: [], 2: []}
    within: list[bool] = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "arm.urdf").write_text(urdf_text())
        robot = folder / "arm.yaml"
        chain(robot, folder / "arm.urdf")
        for number in range(int(asked.odd), 2 * asked.arms, 2):
            hidden, expected, count = drawn(asked.seed, number)
            answer = diagnose([table(folder, measured(hidden, count, number))], robot)
            count_named, wrong = named(answer, expected)
            right[len(expected)].append(count_named == len(expected) and not wrong)
            within += held(answer, expected)
            if not right[len(expected)][-1] or not all(held(answer, expected)):
                print(number, count, f"{hidden.noise_m:.1e}", expected)
                for f in answer.findings:
                    print("   ", f.effect, f.component, f.says)
    for faults, results in right.items():
        print(f"{faults} hidden: {sum(results)} of {len(results)} right")
    print(f"intervals that hold the truth: {sum(within)} of {len(within)}")


if __name__ == "__main__":
    main()
