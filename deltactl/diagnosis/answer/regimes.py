"""Stretches of a recording that a mechanic can name: reversals, directions, speed, load.

In: what a picture has over time. Out: rows of each regime, with the case that names it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from deltactl.diagnosis.answer.picture import BoolArray, FloatArray, bare

STILL_SHARE = 0.02
"""Below this share of its usual top speed a motor counts as resting."""
AFTER_REVERSAL_S = 1.0
TOP_QUANTILE = 0.95
FEWEST_ROWS = 30
"""Readings over which a root mean square is reported."""

Way = Literal["forward", "backward", "stands", "command_stands", "reversed"]
Third = Literal["slow", "fast", "low_load", "high_load"]
Case = Literal["all"] | Way | Third


@dataclass(frozen=True, slots=True, eq=False)
class Regime:
    """A case, of which motor (`1`) or direction of the platform (`x`), and its rows, shape (n,)."""

    case: Case
    which: str
    rows: BoolArray


def regimes(
    t_s: FloatArray, covariates: Mapping[str, FloatArray], rests: BoolArray | None = None
) -> Iterator[Regime]:
    """Every regime that the covariates, each of shape (n,), tell.

    rests: where an axis rests, as the text has it, shape (n,); None: by its speed.
    """
    yield Regime("all", "", np.ones(len(t_s), dtype=np.bool_))
    known = {bare(name): np.nan_to_num(values) for name, values in covariates.items()}
    speeds = {name: v for name, v in known.items() if name.startswith(("speed", "velocity"))}
    for name, speed in speeds.items():
        yield from _of_speed(t_s, which_of(name), speed, rests)
    if speeds:
        joints = {name: speed for name, speed in speeds.items() if name[-1] in "123"}
        size = np.sqrt(np.sum([speed**2 for speed in (joints or speeds).values()], axis=0))
        yield from _thirds("slow", "fast", "", size)
    for name, load in known.items():
        if name.startswith(("torque", "load", "effort")):
            motor = name[-1] if name[-1] in "123" else ""
            yield from _thirds("low_load", "high_load", motor, np.abs(load))


def which_of(name: str) -> str:
    """What a covariate of speed is about: a motor, a direction; empty of a single axis."""
    stem, _, last = name.rpartition("_")
    return last if stem and last in (*"123", *"xyz") else ""


def _of_speed(
    t_s: FloatArray, which: str, speed: FloatArray, rests: BoolArray | None
) -> Iterator[Regime]:
    top = float(np.quantile(np.abs(speed), TOP_QUANTILE)) if len(speed) else 0.0
    if top <= 0.0:
        return
    way = np.where(np.abs(speed) > STILL_SHARE * top, np.sign(speed), 0.0)
    stands = way == 0
    if rests is not None:
        way, stands = np.where(rests, 0.0, way), rests
    yield Regime("forward", which, way > 0)
    yield Regime("backward", which, way < 0)
    yield Regime("stands" if rests is None else "command_stands", which, stands)
    yield Regime("reversed", which, _after_reversal(t_s, way))


def _after_reversal(t_s: FloatArray, way: FloatArray) -> BoolArray:
    """True within AFTER_REVERSAL_S after the direction changed, with a rest in between or not."""
    moving = np.flatnonzero(way != 0)
    turns = moving[1:][np.diff(way[moving]) != 0]
    if not len(turns):
        return np.zeros(len(t_s), dtype=np.bool_)
    last = np.searchsorted(turns, np.arange(len(t_s)), side="right") - 1
    since_s = t_s - t_s[turns[np.maximum(last, 0)]]
    after: BoolArray = (last >= 0) & (since_s <= AFTER_REVERSAL_S)
    return after


def _thirds(low: Third, high: Third, which: str, size: FloatArray) -> Iterator[Regime]:
    least, most = np.quantile(size, [1.0 / 3.0, 2.0 / 3.0])
    if most > least:
        yield Regime(low, which, size <= least)
        yield Regime(high, which, size >= most)
