"""How silent the robot is with nothing wrong: `python -m deltactl.proof.null`.

Compares noiseless readings of a survey with rigid bodies at the commanded angles, and says how
far the simulation's own closed loops came apart.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass

import numpy as np

from deltactl.proof.motions import survey
from deltactl.proof.ranging import ideal_ranges
from deltactl.proof.recorded import Machine, sample_times
from deltactl.proof.robot.as_built import Body, FloatArray, Joints, StepTrain
from deltactl.proof.robot.bodies import Assembly, build
from deltactl.proof.robot.run import TIMESTEP_S, Truth, run


@dataclass(frozen=True)
class Silence:
    """gap_m: largest gap in a loop; mean_m, rms_m, worst_m: readings less rigid ones, (3,)."""

    t_pwm_s: float
    gap_m: float
    mean_m: FloatArray
    rms_m: FloatArray
    worst_m: FloatArray
    took_s: float


def rigid_path(train: StepTrain, t_s: FloatArray) -> FloatArray:
    """Where rigid bodies at the commanded angles put the platform, (n, 3) [m]."""
    assembly = Assembly(build(Body(), Joints(), TIMESTEP_S))
    start = int(assembly.model.joint("platform").qposadr[0])
    pose, path = None, np.empty((len(t_s), 3))
    for row, angles in enumerate(train.smooth(t_s) * Joints().rad_per_step):
        pose = assembly.at(angles, pose)
        path[row] = pose[start : start + 3]
    return path


def silence(train: StepTrain) -> Silence:
    """Measure one motion."""
    begun = time.process_time()
    truth = run(Machine().robot, train)
    took_s = time.process_time() - begun
    rigid = Truth(truth.t_s, rigid_path(train, truth.t_s), truth.arm_rad, 0.0)
    t_s = sample_times(train)
    sensors = Machine().sensors
    off = ideal_ranges(sensors, truth, t_s) - ideal_ranges(sensors, rigid, t_s)
    rms = np.sqrt(np.mean(off**2, axis=0))
    return Silence(
        train.t_pwm_s, truth.gap_m, off.mean(axis=0), rms, np.abs(off).max(axis=0), took_s
    )


def main() -> None:
    """Print one line a step period."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--seconds", type=float, default=120.0)
    chosen = parser.parse_args()
    print("T_PWM   loops open at most   range_x, y, z: mean | RMS | worst [um]   CPU")
    for t_pwm_s in (0.001, 0.002, 0.004):
        rng = np.random.default_rng(chosen.seed)
        s = silence(survey(rng, chosen.seconds, t_pwm_s))
        triples = " | ".join(
            ", ".join(f"{1e6 * value:.0f}" for value in part)
            for part in (s.mean_m, s.rms_m, s.worst_m)
        )
        print(f"{1e3 * t_pwm_s:.0f} ms    {1e6 * s.gap_m:.0f} um   {triples}   {s.took_s:.1f} s")


if __name__ == "__main__":
    main()
