"""Random arm angles one after another: single arms, all arms alike, and all at once."""

from __future__ import annotations

import numpy as np

from deltactl.proof.robot.stepping import IntArray, StepTrain, cut, together

LOWEST, HIGHEST = 667, 3333
"""Microsteps: 15 to 75 degrees, where every combination of angles can be assembled, also by a robot
with 6 mm more base radius. With all arms level even the robot of the file is at a singular pose:
a wider one is driven through it and its arm stays flipped, which a machine's end stops prevent."""
DWELLS_S = (0.1, 0.5)
KINDS = ("one", "alike", "all")


def survey(rng: np.random.Generator, seconds: float, t_pwm_s: float) -> StepTrain:
    """A survey of about `seconds`, cut to it."""
    here = rng.integers(1000, 1700, 3)
    targets: list[IntArray] = []
    dwells: list[float] = []
    start, spent = here, 0.0
    while spent < seconds:
        target = _next(rng, here)
        targets.append(target)
        dwells.append(float(rng.uniform(*DWELLS_S)))
        spent += float(np.abs(target - here).max()) * t_pwm_s + dwells[-1]
        here = target
    return cut(together(start, np.array(targets), np.array(dwells), t_pwm_s), seconds)


def _next(rng: np.random.Generator, here: IntArray) -> IntArray:
    kind = rng.choice(KINDS, p=(0.4, 0.2, 0.4))
    if kind == "all":
        return rng.integers(LOWEST, HIGHEST + 1, 3)
    target = here.copy()
    goal = int(rng.integers(LOWEST, HIGHEST + 1))
    if kind == "one":
        target[int(rng.integers(3))] = goal
        return target
    return np.clip(target + goal - int(np.mean(here)), LOWEST, HIGHEST)
