"""How good the simulation itself is: do the loops stay closed, and is energy kept?

python -m deltactl.proof.micro.checks
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from time import process_time

import mujoco
import numpy as np

from deltactl.proof.micro.as_built import MicroDelta, Three, each
from deltactl.proof.micro.bodies import PERIOD_S, Rods
from deltactl.proof.micro.plant import MicroPlant

START_RAD: Three = (0.5, 0.6, 0.4)
SWAY_A, SWAY_HZ = 0.02, 4.0
HELD_A = 0.028
"""About what holds the arms at 30 degrees."""


@dataclass(frozen=True, slots=True)
class Check:
    """What came of one way to simulate."""

    rods: Rods
    period_s: float
    gap_m: float
    """Largest constraint error."""
    energy_share: float
    """Largest change of the energy of a free robot, as a share of what it exchanges."""
    step_s: float
    """Process CPU time of a step."""


def frictionless(robot: MicroDelta) -> MicroDelta:
    """The same without anything that takes energy away."""
    drives = replace(
        robot.drives, rotor_viscous_nmsprad=each(0.0), bearing_viscous_nmsprad=each(0.0)
    )
    return replace(robot, drives=drives)


def energy_j(plant: MicroPlant) -> tuple[float, float]:
    """Energy of height and of motion, rotors and all."""
    mujoco.mj_forward(plant.model, plant.data)
    mujoco.mj_energyPos(plant.model, plant.data)
    mujoco.mj_energyVel(plant.model, plant.data)
    return float(plant.data.energy[0]), float(plant.data.energy[1])


def check(rods: Rods, period_s: float = PERIOD_S, seconds: float = 0.12) -> Check:
    """Let a robot without friction fall from START_RAD, and sway one with friction."""
    fall = MicroPlant(frictionless(MicroDelta()), START_RAD, rods, period_s, dry=False)
    total, exchanged, worst = sum(energy_j(fall)), 0.0, 0.0
    for _ in range(round(seconds / period_s / 10)):
        for _ in range(10):
            fall.advance(0.0, 0.0, 0.0)
        height, motion = energy_j(fall)
        worst, exchanged = max(worst, abs(height + motion - total)), max(exchanged, motion)
    gap_m, step_s = _sway(rods, period_s)
    return Check(rods, period_s, gap_m, worst / exchanged, step_s)


def _sway(rods: Rods, period_s: float) -> tuple[float, float]:
    plant = MicroPlant(MicroDelta(), START_RAD, rods, period_s)
    ticks = round(0.5 / period_s)
    wave = HELD_A + SWAY_A * np.sin(2.0 * np.pi * SWAY_HZ * period_s * np.arange(ticks))
    gap_m, spent_s = 0.0, 0.0
    currents: list[float] = wave.tolist()
    for start in range(0, ticks, 50):
        begun = process_time()
        for current in currents[start : start + 50]:
            plant.advance(current, current, -current)
        spent_s += process_time() - begun
        gap_m = max(gap_m, plant.gap_m())
    return gap_m, spent_s / ticks


def main() -> None:
    """Print the table of docs/micro-delta.md."""
    print("| rods | period [us] | largest loop-closure error [nm] | energy error | CPU/step [us] |")
    print("|---|---|---|---|---|")
    for rods in Rods:
        for period_s in (PERIOD_S, PERIOD_S / 2, PERIOD_S / 5):
            found = check(rods, period_s)
            print(
                f"| {rods.value} | {1e6 * period_s:.0f} | {1e9 * found.gap_m:.1f} |"
                f" {100 * found.energy_share:.3f} % | {1e6 * found.step_s:.1f} |"
            )


if __name__ == "__main__":
    main()
