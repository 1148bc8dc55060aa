"""Stretches of a recording that a mechanic can name: reversals, directions, speed, load."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from deltactl.diagnosis.answer.picture import FloatArray
from deltactl.diagnosis.report.page.residuals import BoolArray, Mismatch, rms
from deltactl.diagnosis.report.phrases import words

STILL_SHARE = 0.02
"""Below this share of its usual top speed a motor counts as standing."""
AFTER_REVERSAL_S = 1.0
TOP_QUANTILE = 0.95
FEWEST = 30
COMMAND_STANDS = "the axis stands, or settles, at its command"
WAYS: tuple[tuple[str, tuple[str, str, str, str]], ...] = (
    (r".*_([123])",
     ("motor {} moves forward", "motor {} moves backward", "motor {} stands", "motor {} reversed")),
    (r".*_([xyz])",
     ("the platform moves towards +{}", "the platform moves towards -{}",
      "the platform does not move along {}", "the platform reversed along {}")),
    (r".*",
     ("the axis moves forward", "the axis moves backward", "the axis stands", "the axis reversed")),
)  # fmt: skip
"""Covariates by their end: forward, backward, standing, and what it did shortly before."""


@dataclass(frozen=True, slots=True)
class Regime:
    """How large the mismatch is in one regime, before and after, as RMS."""

    name: str
    before: float
    after: float


def regimes(
    t_s: FloatArray,
    covariates: Mapping[str, FloatArray],
    channels: list[Mismatch],
    rests: BoolArray | None = None,
) -> list[Regime]:
    """RMS over the given channels (all in one unit) in every regime that occurs.

    Over all readings, also those that lie too far out to be drawn: as the figures of the fit.
    rests: where an axis stands, as the text has it, shape (n,); None: by its speed.
    """
    found = []
    for name, chosen in _selections(t_s, covariates, rests):
        seen = sum(int((chosen & np.isfinite(one.all_before)).sum()) for one in channels)
        if seen < FEWEST:
            continue
        before, after = (
            rms(
                np.concatenate([getattr(one, f"all_{which}") for one in channels]),
                np.tile(chosen, len(channels)),
            )
            for which in ("before", "after")
        )
        found.append(Regime(name, before, after))
    return found


def _selections(
    t_s: FloatArray, covariates: Mapping[str, FloatArray], rests: BoolArray | None
) -> Iterator[tuple[str, BoolArray]]:
    yield "all the time", np.ones(len(t_s), dtype=np.bool_)
    speeds = {
        words.bare(name): np.nan_to_num(values)
        for name, values in covariates.items()
        if re.match(r"(speed|velocity)", words.bare(name))
    }
    for name, speed in speeds.items():
        yield from _of_speed(t_s, _ways(name), speed, rests)
    if speeds:
        joints = {name: speed for name, speed in speeds.items() if name[-1] in "123"}
        yield from _slow_and_fast(joints or speeds)
    for name, values in covariates.items():
        if re.match(r"(torque|load|effort)", words.bare(name)):
            yield from _of_load(_who(words.bare(name)), np.nan_to_num(values))


def _of_speed(
    t_s: FloatArray, ways: list[str], speed: FloatArray, rests: BoolArray | None
) -> Iterator[tuple[str, BoolArray]]:
    top = float(np.quantile(np.abs(speed), TOP_QUANTILE)) if len(speed) else 0.0
    if top <= 0.0:
        return
    way = np.where(np.abs(speed) > STILL_SHARE * top, np.sign(speed), 0.0)
    stands = way == 0
    if rests is not None:
        way, stands = np.where(rests, 0.0, way), rests
    forward, backward, still, reversed_ = ways
    yield forward, way > 0
    yield backward, way < 0
    yield still if rests is None else COMMAND_STANDS, stands
    yield f"within {AFTER_REVERSAL_S:.0f} s after {reversed_}", _after_reversal(t_s, way)


def _after_reversal(t_s: FloatArray, way: FloatArray) -> BoolArray:
    """True within AFTER_REVERSAL_S after the direction changed, standing in between or not."""
    moving = np.flatnonzero(way != 0)
    turns = moving[1:][np.diff(way[moving]) != 0]
    if not len(turns):
        return np.zeros(len(t_s), dtype=np.bool_)
    last = np.searchsorted(turns, np.arange(len(t_s)), side="right") - 1
    since_s = t_s - t_s[turns[np.maximum(last, 0)]]
    after: BoolArray = (last >= 0) & (since_s <= AFTER_REVERSAL_S)
    return after


def _slow_and_fast(speeds: Mapping[str, FloatArray]) -> Iterator[tuple[str, BoolArray]]:
    size = np.sqrt(np.sum([speed**2 for speed in speeds.values()], axis=0))
    low, high = np.quantile(size, [1.0 / 3.0, 2.0 / 3.0])
    if high > low:
        yield "slowest third", size <= low
        yield "fastest third", size >= high


def _of_load(who: str, load: FloatArray) -> Iterator[tuple[str, BoolArray]]:
    size = np.abs(load)
    low, high = np.quantile(size, [1.0 / 3.0, 2.0 / 3.0])
    if high > low:
        yield f"{who} under low load", size <= low
        yield f"{who} under high load", size >= high


def _ways(name: str) -> list[str]:
    """What a covariate of speed is about: a motor, the platform along an axis, or a lone axis."""
    fitting = ((re.fullmatch(pattern, name), texts) for pattern, texts in WAYS)
    found, texts = next((found, texts) for found, texts in fitting if found)
    return [text.format(*found.groups()) for text in texts]


def _who(name: str) -> str:
    return f"motor {name[-1]}" if name[-1] in "123" else "the axis"
