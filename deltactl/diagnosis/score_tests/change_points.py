"""Things that happen once: a scan for the moment of a loss."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from deltactl.diagnosis.estimation.change_point_search import told_between
from deltactl.diagnosis.estimation.change_point_timing import late_of, seen_s
from deltactl.diagnosis.estimation.estimate import Solution, without
from deltactl.diagnosis.estimation.least_squares import Fitter
from deltactl.diagnosis.plants.candidate import Candidate
from deltactl.diagnosis.plants.traits import traits_of
from deltactl.diagnosis.score_tests.options import SCORE_TESTS


@dataclass(frozen=True, slots=True, eq=False)
class Jump:
    """The best moment for a jump at one joint."""

    candidate: Candidate
    gain: float
    time_s: float
    interval_s: tuple[float, float]


def jumps(
    fitter: Fitter, solution: Solution, rad_per_step: float, near_s: float | None = None
) -> list[Jump]:
    """For each joint the moment at which a lasting jump explains most of the residual.

    near_s: look around this moment only.
    """
    model = fitter.model
    rows = fitter.whiten.rows
    order = np.argsort(rows, kind="stable")[::-1]
    times = model.readings.t_s[rows[order]]
    basis = solution.basis[: len(rows)][order]
    residual = solution.residual[: len(rows)][order]
    earliest_s, latest_s = told_between(times)
    inside = (times > earliest_s) & (times < latest_s)
    if near_s is not None:
        inside &= np.abs(times - near_s) < SCORE_TESTS.near_s
    found, events = [], traits_of(model).events
    for location, change in model.inputs().items():
        if location not in events:
            continue
        column = fitter.whiten(-rad_per_step * change)[order]
        if not column.any():
            continue
        along = np.cumsum(column * residual)
        shared = column[:, None] * basis
        np.cumsum(shared, axis=0, out=shared)
        power = np.cumsum(column**2)
        left = power - np.einsum("ij,ij->i", shared, shared)
        usable = inside & (left > SCORE_TESTS.least_own * power[-1])
        gain = np.where(usable, along**2 / np.maximum(left, 1e-30), 0.0)
        best = int(np.argmax(gain))
        if not gain[best]:
            continue
        near, at_s = times[(gain > gain[best] - 3.84) & usable], float(times[best])
        # The first reading that shows a jump comes up to one period after it.
        before_s = model.readings.period_s
        within_s = float(near.min(initial=at_s)) - before_s, float(near.max(initial=at_s))
        jump = Jump(events[location](at_s), float(gain[best]), at_s - 0.5 * before_s, within_s)
        found.append(jump)
    return found


def moment(fitter: Fitter, solution: Solution, number: int, rad_per_step: float) -> Jump | None:
    """When the jump that is term `number` happened, with all others fitted, and the interval."""
    term = solution.terms[number]
    shown_s = seen_s(term)
    if shown_s is None:
        return None
    rest = without(solution.terms, number)
    bare = fitter.solve(rest, solution.frees, solution.nuisances, steps=2)
    late_s = late_of(solution.terms)
    for jump in jumps(fitter, bare, rad_per_step, shown_s):
        if jump.candidate.component == term.candidate.component:
            first_s, last_s = jump.interval_s
            return replace(
                jump, time_s=jump.time_s - late_s, interval_s=(first_s - late_s, last_s - late_s)
            )
    return None
