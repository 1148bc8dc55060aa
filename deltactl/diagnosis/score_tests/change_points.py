"""Things that happen once: a scan for the moment of a loss, and runs of repeated readings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from deltactl.diagnosis.estimation.change_point_search import told_between
from deltactl.diagnosis.estimation.change_point_timing import late_of, seen_s
from deltactl.diagnosis.estimation.estimate import Solution, without
from deltactl.diagnosis.estimation.least_squares import Fitter
from deltactl.diagnosis.observations.readings import BoolArray, Readings, long_repeats
from deltactl.diagnosis.plants.candidate import Candidate
from deltactl.diagnosis.plants.contract import Model
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


@dataclass(frozen=True, slots=True)
class Stale:
    """A stretch [first, last] of rows in which a sensor repeats one number."""

    channel: str
    first: int
    last: int
    log_p: float


def stale_runs(readings: Readings, channels: Sequence[str]) -> list[Stale]:
    """Repeats in some channels, too long for rounding and noise to make by chance."""
    found: list[Stale] = []
    for column, name in enumerate(readings.names):
        if name not in channels:
            continue
        values = readings.values[:, column]
        rate = float(np.mean(np.diff(values) == 0.0))
        if not 0.0 < rate < 0.6:
            continue
        own: list[Stale] = []
        for first, last in long_repeats(values, SCORE_TESTS.fewest_repeats):
            log_p = float(np.log(len(values)) + (last - first) * np.log(rate))
            if log_p < np.log(SCORE_TESTS.chance):
                own.append(Stale(name, first, last, log_p))
        held = [values[run.first] for run in own]
        if len(own) < SCORE_TESTS.many or len(set(held)) > len(own) // 2:
            found += own  # the same value again and again is the end of a range, not an old value
    return found


def without_stale(model: Model) -> tuple[BoolArray, list[Stale]]:
    """The mask of valid readings (n, channels) less repeats of old values, and those repeats."""
    readings = model.readings
    runs = stale_runs(readings, traits_of(model).repeating)
    kept = readings.valid.copy()
    for run in runs:
        kept[run.first + 1 : run.last + 1, readings.names.index(run.channel)] = False
    return kept, runs
