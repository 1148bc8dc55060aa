"""A scan for the moment at which a stepper axis lost steps."""

from __future__ import annotations

import numpy as np

from diagnosis.estimation.estimate import Solution
from diagnosis.estimation.least_squares import Fitter
from diagnosis.estimation.penalties import EVENT_PENALTY, Trial
from diagnosis.evidence.chi2_tail import log_sf
from diagnosis.observations.readings import FloatArray
from diagnosis.plants import axis_candidates as moves
from diagnosis.plants.candidate import Term
from diagnosis.plants.contract import Model
from models.effects.lone_axis import COMPONENT, command_effects

EDGE = 0.05
"""Share of the travel at each end in which no loss is looked for."""
LEAST_LEFT = 0.02
"""Share of a jump that the rest of the model must leave, or it cannot be told from an offset."""


def gains(fitter: Fitter, solution: Solution, model: Model) -> tuple[FloatArray, FloatArray]:
    """Times and the chi-square that a lasting jump at each would gain, (m,) each, latest first."""
    rows = fitter.whiten.rows
    order = np.argsort(rows, kind="stable")[::-1]
    times = model.readings.t_s[rows[order]]
    basis = solution.basis[: len(rows)][order]
    column = fitter.whiten(model.ports()[COMPONENT])[order]
    along = np.cumsum(column * solution.residual[: len(rows)][order])
    shared = np.cumsum(column[:, None] * basis, axis=0)
    power = np.cumsum(column**2)
    left = power - np.sum(shared**2, axis=1)
    # Steps are lost in motion, and a loss before the first or after the last shows as an offset.
    driver = next(iter(model.drivers().values()))
    travel = np.cumsum(np.abs(np.diff(driver, prepend=driver[0])))[rows[order]]
    margin = EDGE * (travel[0] - travel[-1])
    usable = (travel > travel[-1] + margin) & (travel < travel[0] - margin)
    usable &= left > LEAST_LEFT * np.minimum(power, power[-1] - power)
    return times, np.where(usable, along**2 / np.maximum(left, 1e-30), 0.0)


def scan(fitter: Fitter, solution: Solution, model: Model, rad_per_step: float) -> list[Trial]:
    """The best moment for a loss, as a start for a refit."""
    times, gain = gains(fitter, solution, model)
    best = int(np.argmax(gain))
    if not gain[best] > 0.0:
        return []
    kind = command_effects("rotary")["lost_steps"]
    step = max(1e-7 / rad_per_step, 1.0)
    candidate = moves.jump(kind, float(times[best]), step)
    start = Term(candidate, np.array([0.0, float(times[best])]))
    return [Trial(start, float(gain[best]), log_sf(float(gain[best]), 1), EVENT_PENALTY)]
