"""Is the p of "nothing is missing" right? Many noises over one motion of a healthy robot.

    python benchmarks/proofs/false_alarms.py [--motion survey|circle|heart|spiral] [--seconds S]
                                      [--rho R ...] [--draws N] [--seed N]

Simulates the MuJoCo robot once (extra `proof`), then draws noise again and again: first-order
correlated, rounded to millimetres, with outliers and invalid readings. A right p is below 5 % in
5 % of the draws; one that is seldom small is on the safe side. 5 s of one core a draw of 120 s.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np

from deltactl.diagnosis.api import diagnose_recordings
from deltactl.models.robot_files import load_delta
from deltactl.proof.cases import ROBOT, move
from deltactl.proof.prove.reliability import wilson
from deltactl.proof.ranging import Noise, read
from deltactl.proof.recorded import Machine, sample_times, table
from deltactl.proof.robot.run import run

LEVELS = (0.005, 0.01, 0.05, 0.1, 0.5)
MOTIONS = ("survey", "circle", "heart", "spiral")
T_PWM_S = 0.002


def chances(motion: str, seconds: float, rho: float, draws: int, seed: int) -> list[float]:
    """p of 'nothing is missing' for each draw of the noise."""
    rng = np.random.default_rng([seed, MOTIONS.index(motion)])
    train = move(rng, motion, seconds, T_PWM_S)
    machine = Machine(noise=Noise(sigma_m=0.002, rho=rho))
    truth, t_s = run(machine.robot, train), sample_times(train)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "robot.yaml"
        file.write_text(ROBOT, encoding="utf-8")
        robot = load_delta(file)
    found = []
    for _ in range(draws):
        ranges, status = read(machine.sensors, machine.noise, truth, t_s, rng)
        answer = diagnose_recordings(robot, [table(t_s, train, ranges, status)])
        found.append(answer.false_alarm_p)
    return found


def main() -> int:
    """One line for each correlation."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--motion", choices=MOTIONS, default="survey")
    parser.add_argument("--seconds", type=float, default=120.0)
    parser.add_argument("--rho", type=float, nargs="+", default=[0.0, 0.3, 0.6])
    parser.add_argument("--draws", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    chosen = parser.parse_args()
    print(f"{chosen.motion} of {chosen.seconds:.0f} s: share of {chosen.draws} draws with p below")
    print("rho   " + "".join(f"{level:>24}" for level in LEVELS))
    for rho in chosen.rho:
        p = np.array(chances(chosen.motion, chosen.seconds, rho, chosen.draws, chosen.seed))
        cells = []
        for level in LEVELS:
            hits = int(np.sum(p < level))
            low, high = wilson(hits, len(p))
            cells.append(f"{hits / len(p):.3f} ({low:.3f} to {high:.3f})")
        print(f"{rho:<6}" + "".join(f"{cell:>24}" for cell in cells), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
