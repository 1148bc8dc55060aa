"""Signals over time: recursions without a loop, and a motion between the rows of a recording.

Maps x -> x' that compose are scanned by doubling. A first-order filter is x' = a x + b; a dead band
is x' = min(high, max(low, x + d)). Both kinds of map are closed under composition, so all prefixes
come out in log2(n) passes (Hillis and Steele 1986, 'Data parallel algorithms').

Between rows a motion is smooth, and at rest where its neighbours are. Where rows are as far apart
as a ramp takes, straight lines between them leave a pattern at every stop, which looks like a
periodic error or like a drive of another order. So a motion is a cubic between rows: with the
slopes of a spline, limited as Fritsch and Carlson 1980 ('Monotone piecewise cubic interpolation')
limit them, so that it goes beyond no row on its way, and where it turns as Dougherty, Edelman and
Hyman 1989 ('Nonnegativity-, monotonicity-, or convexity-preserving cubic and quintic Hermite
interpolation') do: a leap between two rows is not the slope of the motion that begins after it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from deltactl.models.robot import FloatArray

try:
    from scipy.linalg import lapack
except ImportError:  # a robot that only runs needs no SciPy
    lapack = None

AnyArray = np.ndarray[Any, np.dtype[Any]]
FORGOTTEN = 1e-18


def linear(gain: AnyArray, addend: AnyArray, before: AnyArray) -> AnyArray:
    """x[k] = gain[k] x[k-1] + addend[k] along the first axis, with x[-1] = `before`.

    gain: (n,); addend: (n, m). A gain of 0 starts afresh.
    """
    total = np.array(addend, dtype=np.result_type(gain, addend))
    total[0] += gain[0] * before
    return by_doubling(gain, total) if lapack is None else by_substitution(gain, total)


def by_substitution(gain: AnyArray, total: AnyArray) -> AnyArray:
    """The same from the start 0, with SciPy: the recursion is a band of two diagonals."""
    assert lapack is not None
    band = np.empty((2, len(gain)), dtype=total.dtype)
    band[1, :-1] = -gain[1:]
    solve = lapack.ztbtrs if np.iscomplexobj(total) else lapack.dtbtrs
    solved: AnyArray = solve(band, total, uplo="L", diag="U")[0]
    return solved


def by_doubling(gain: AnyArray, total: AnyArray) -> AnyArray:
    """The same without it."""
    gain = np.array(gain)[:, None]
    shift, most = 1, float(np.abs(gain).max(initial=0.0))
    while shift < len(total) and most > FORGOTTEN:
        total[shift:] += gain[shift:] * total[:-shift]
        gain[shift:] *= gain[:-shift]
        gain[:shift] = 0.0
        shift, most = 2 * shift, most**2
    return total


def clipped(move: FloatArray, low: FloatArray, high: FloatArray, before: float) -> FloatArray:
    """x[k] = min(high[k], max(low[k], x[k-1] + move[k])), with x[-1] = `before`; all (n,)."""
    move, low, high = move.copy(), low.copy(), high.copy()
    shift = 1
    while shift < len(move) and (low[shift:] < high[shift:]).any():
        # The map of k after the map of k - shift, for all k at once.
        new_low = np.minimum(high[shift:], np.maximum(low[shift:], low[:-shift] + move[shift:]))
        new_high = np.minimum(high[shift:], np.maximum(low[shift:], high[:-shift] + move[shift:]))
        move[shift:] = move[shift:] + move[:-shift]
        low[shift:], high[shift:] = new_low, new_high
        shift *= 2
    result: FloatArray = np.minimum(high, np.maximum(low, before + move))
    return result


def lagged(x: FloatArray, step_s: FloatArray, time_s: float, memory: dict[str, Any]) -> FloatArray:
    """First-order lag of each column of x (n, m) taken as straight between samples.

    A step of 0 s starts afresh at the input. `memory` carries the state between blocks.
    """
    if time_s <= 1e-9:
        return x
    ratio = np.maximum(step_s, 1e-12) / time_s
    gain = np.exp(-ratio)
    mean = -np.expm1(-ratio) / ratio
    at_start = step_s <= 0.0
    gain[at_start] = 0.0
    previous = np.vstack([memory.get("x", x[0])[None, :], x[:-1]])
    addend = (1.0 - mean)[:, None] * x + (mean - gain)[:, None] * previous
    addend[at_start] = x[at_start]
    y = linear(gain, addend, memory.get("y", x[0]))
    memory["x"], memory["y"] = x[-1].copy(), y[-1].copy()
    return y


def delayed(
    x: FloatArray,
    t_s: FloatArray,
    stretch_start_s: FloatArray,
    delay_s: float,
    memory: dict[str, Any],
) -> FloatArray:
    """Each column of x (n, m) as it was `delay_s` earlier, the first value before a start.

    `memory` keeps as much of the past as the delay needs; without a block before, a stretch
    starts afresh.
    """
    t_all, x_all, start = t_s, x, stretch_start_s
    if "t" in memory:
        t_all = np.concatenate([memory["t"], t_s])
        x_all = np.concatenate([memory["x"], x])
        start = np.where(start <= t_s[0], memory["start"], start)
    at = np.maximum(t_s - delay_s, start)
    result = np.stack([np.interp(at, t_all, x_all[:, j]) for j in range(x.shape[1])], axis=1)
    keep = int(np.searchsorted(t_all, t_s[-1] - abs(delay_s))) - 1
    memory["t"], memory["x"] = t_all[max(keep, 0) :].copy(), x_all[max(keep, 0) :].copy()
    memory["start"] = float(start[-1])
    return result


SHORT = 0.01
"""Part of a time constant below which moments are computed as a series."""
STEEPEST = 3.0
"""Times the smaller of the neighbouring rises: beyond it a cubic may turn back."""
STEEPER = 1.5
"""Times the least slope of the parabolas beside a row."""
LEAST_ROWS = 4
LINE_ERROR = 8.0
"""A straight line between rows is off by the second difference over this at most."""


def between_rows(x: FloatArray) -> FloatArray:
    """Bound on what a straight line between rows leaves out of x (n,), in the step before each."""
    bent = np.zeros(len(x))
    bent[1:-1] = np.abs(np.diff(x, 2)) / LINE_ERROR
    bent[1:] = np.maximum(bent[1:], bent[:-1])
    return bent


def slopes_of(x: FloatArray, t_s: FloatArray, step_s: FloatArray) -> FloatArray:
    """Slope of x (n,) at its rows; step_s: time since the row before, 0 where a stretch begins."""
    from scipy.interpolate import CubicSpline  # only diagnosis looks between rows

    if len(x) < LEAST_ROWS:
        return np.zeros(len(x))
    slope = np.asarray(CubicSpline(t_s, x)(t_s, 1))
    secant = np.divide(
        np.diff(x), step_s[1:], out=np.full(len(x) - 1, np.nan), where=step_s[1:] > 0
    )
    before, after = np.append(np.nan, secant), np.append(secant, np.nan)
    least = np.fmin(np.abs(before), np.abs(after))
    steepest = STEEPER * _least_of_parabolas(slope, before, after, step_s)
    same = before * after > 0.0
    steepest = np.where(same, np.clip(steepest, least, STEEPEST * least), steepest)
    wrong = same & (slope * before < 0.0)
    slope = np.where(wrong, 0.0, np.clip(slope, -steepest, steepest))
    slope[(before == 0.0) | (after == 0.0)] = 0.0
    edge = np.isnan(before) | np.isnan(after)
    slope[edge] = np.nan_to_num(np.fmax(before, after))[edge]
    return slope


def _least_of_parabolas(
    slope: FloatArray, before: FloatArray, after: FloatArray, step_s: FloatArray
) -> FloatArray:
    """Least slope (n,) of the parabolas before, at and after a row; 0 where one goes another way.

    A parabola that a stretch is too short for does not count.
    """
    here, there = step_s, np.append(step_s[1:], np.nan)
    # The slope of a parabola changes by as much within a step as between the middles of two steps.
    change = (after - before) / np.maximum(here + there, 1e-12)
    at = before + here * change
    parabolas = np.stack(
        [at, before + here * np.roll(change, 1), after - there * np.roll(change, -1)]
    )
    sizes = np.where(parabolas * slope < 0.0, 0.0, np.abs(parabolas))
    least: FloatArray = np.nanmin(sizes, axis=0, initial=np.inf)
    return least


def late(
    x: FloatArray,
    slopes: FloatArray,
    t_s: FloatArray,
    stretch_start_s: FloatArray,
    dead_s: float,
    time_s: float,
) -> FloatArray:
    """A motion x (n,) behind a dead time and a first-order lag, at its rows; a stretch begins at
    rest. All (n,).
    """
    at = np.clip(t_s - dead_s, stretch_start_s, None)
    row = np.clip(np.searchsorted(t_s, at, side="right") - 1, 0, len(t_s) - 2)
    since_s = at - t_s[row]
    width_s = np.maximum(t_s[row + 1] - t_s[row], 1e-12)
    there, slope = _within(x, slopes, row, since_s, width_s)
    if time_s <= 1e-9:
        return there
    step_s = np.diff(t_s, prepend=t_s[0])
    step_s[t_s <= stretch_start_s] = 0.0
    start, from_slope = np.append(x[:1], x[:-1]), np.append(slopes[:1], slopes[:-1])
    gain, addend = _response(start, x, from_slope, slopes, step_s, time_s)
    fresh = step_s <= 0.0
    gain[fresh], addend[fresh] = 0.0, x[fresh]
    lagged = linear(gain, addend[:, None], x[:1])[:, 0]
    decay, more = _response(x[row], there, slopes[row], slope, since_s, time_s)
    found: FloatArray = decay * lagged[row] + more
    return found


def _within(
    x: FloatArray, slopes: FloatArray, row: FloatArray, since_s: FloatArray, width_s: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Value and slope of the cubic after a row, (n,) each."""
    share, rise = np.minimum(since_s / width_s, 1.0), x[row + 1] - x[row]
    first, last = width_s * slopes[row] - rise, rise - width_s * slopes[row + 1]
    back = 1.0 - share
    value = x[row] + share * rise + share * back * (back * first + share * last)
    bend = back * (back - 2.0 * share) * first + share * (2.0 * back - share) * last
    return value, (rise + bend) / width_s


def _response(
    start: FloatArray,
    end: FloatArray,
    from_slope: FloatArray,
    to_slope: FloatArray,
    step_s: FloatArray,
    time_s: float,
) -> tuple[FloatArray, FloatArray]:
    """What a lag keeps of its state over a step, and what a cubic adds to it, (n,) each."""
    ratio = step_s / time_s
    zeroth, first, second, third = _moments(ratio)
    rise = end - start
    bent = (first - 2.0 * second + third) * (step_s * from_slope - rise)
    bent -= (second - third) * (step_s * to_slope - rise)
    return np.exp(-ratio), zeroth * start + first * rise + bent


def _moments(ratio: FloatArray) -> tuple[FloatArray, ...]:
    """Moments of the share of a step, powers 0 to 3, as a lag weighs them; (n,) each."""
    safe = np.maximum(ratio, SHORT)
    exact = -np.expm1(-safe)
    found = [-np.expm1(-ratio)]
    for power in (1.0, 2.0, 3.0):
        exact = 1.0 - power / safe * exact
        a, b, c = power + 1.0, power + 2.0, power + 3.0
        series = ratio * (1.0 / a - ratio / (a * b) + ratio**2 / (a * b * c))
        found.append(np.where(ratio < SHORT, series, exact))
    return tuple(found)
