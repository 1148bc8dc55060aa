"""Recursions over time without a loop: maps x -> x' that compose are scanned by doubling.

A first-order filter is x' = a x + b; a dead band is x' = min(high, max(low, x + d)). Both kinds
of map are closed under composition, so all prefixes come out in log2(n) passes (Hillis and
Steele 1986, 'Data parallel algorithms').
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
