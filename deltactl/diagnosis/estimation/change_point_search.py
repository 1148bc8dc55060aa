"""When an event fits best: a search, for the cost over its moment has a cusp at every reading."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from deltactl.diagnosis.estimation.change_point_timing import aligned, seen_s, shown_later
from deltactl.diagnosis.estimation.estimate import Point
from deltactl.diagnosis.estimation.options import ESTIMATION
from deltactl.diagnosis.observations.readings import FloatArray, Readings
from deltactl.diagnosis.plants.candidate import Term


def told_between(t_s: FloatArray) -> tuple[float, float]:
    """Between which times [s] an event can be distinguished from an offset; t_s: sorted, either
    way."""
    first_s, last_s = sorted((float(t_s[0]), float(t_s[-1])))
    edge_s = ESTIMATION.edge * (last_s - first_s)
    return first_s + edge_s, last_s - edge_s


def better_moment(
    readings: Readings,
    predict: Callable[[Sequence[Term]], FloatArray],
    whitened: Callable[[FloatArray], FloatArray],
    at: Point,
    number: int,
    basis: FloatArray,
    least: float,
) -> tuple[Term, ...] | None:
    """The terms with event `number` at a better moment; None for other terms, or if none is.

    whitened: of a difference of the channels, (n, channels) -> (m,). basis: of the spline terms,
    (m, q). least: chi-square that it must come below. What is predicted changes between the two
    moments only, so that one prediction, at the farthest, tells of all on its way. An event stays
    away from the ends, where it is an offset, or nothing.
    """
    term, period_s = at.terms[number], readings.period_s
    shown_s = seen_s(term)
    if shown_s is None:
        return None
    best, t_s = None, readings.t_s
    earliest_s, latest_s = told_between(t_s)
    for way in (-1, 1):
        moments = [way * count for count in ESTIMATION.moments]
        if not earliest_s < shown_s + moments[0] * period_s < latest_s:
            continue
        farthest = _moved(at.terms, number, moments[-1] * period_s)
        change = predict([*at.nuisances, *farthest]) - at.predicted
        for moment in moments:
            moment_s = shown_s + moment * period_s
            if not earliest_s < moment_s < latest_s:
                break
            first_s, last_s = sorted((shown_s, moment_s))
            between = (t_s >= first_s) & (t_s < last_s)
            some = whitened(np.where(between[:, None], change, 0.0))
            cost = at.cost + _costlier(at, basis, some)
            if cost < least:
                best, least = moment, cost
    return None if best is None else _moved(at.terms, number, best * period_s)


def _moved(terms: tuple[Term, ...], number: int, by_s: float) -> tuple[Term, ...]:
    """Terms with an event shown so much later."""
    later = shown_later(terms[number], by_s)
    assert later is not None
    return aligned((*terms[:number], later, *terms[number + 1 :]))


def _costlier(at: Point, basis: FloatArray, change: FloatArray) -> float:
    """Chi-square that a change (m,) of a few whitened readings adds, less what the basis takes."""
    rows = np.flatnonzero(change)
    some = change[rows]
    taken = some @ basis[rows]
    return float(some @ some - taken @ taken - 2.0 * (at.residual[rows] @ some - at.taken @ taken))
