"""What an ideal observer could tell from a recording, by the physics alone.

The observer knows the machine, the motion and the noise, and compares noiseless signals in standard
deviations of that noise. It decides how large an effect has to be to be seen, which other effects
make the same pattern in this motion (a tie), and how well a size can be known (Cramer-Rao).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from deltactl.proof.axis.catalogue import Kind, Scale
from deltactl.proof.axis.commanded import Sizes, Values
from deltactl.proof.axis.motions import FloatArray
from deltactl.proof.axis.sensing import Noise, whitened

TIE = 2.0 * math.log(0.95 / 0.05)
"""Chi-square below which an alternative is a tie: an observer that knows machine, motion and noise
is then usually less than 95 % sure."""
SAME = 4.0
"""Chi-square below which nobody could prefer either: it is the same effect in this motion."""
OF_IT = 0.2
"""No larger share of the effect's own chi-square: of a faint one nearly everything is below."""
REFITS = 10
"""Secants of an alternative that is refitted; each gains a digit or so."""
HOPELESS = 400.0
"""Chi-square from which on an alternative that a refit did not halve is no tie."""
BEYOND = 4.0
"""Times the largest that is drawn an alternative may have: half the gain is twice the mass."""
NUDGE = 1e-3
"""Share of a size by which it is moved, to see what it does: small beside any interval drawn."""
WAVES = ("transmission_error", "encoder_error")
PART = 0.02
"""Change of a size for a derivative, in sizes."""


class Machine(Protocol):
    """A simulator; `ideal` leaves out what the vocabulary's words do not mean."""

    def clean(self, sizes: Sizes, rows_s: FloatArray, ideal: bool = False) -> FloatArray: ...


@dataclass(frozen=True)
class Observer:
    """A machine in its motion, the rows that tell something, and their noise.

    every: rows averaged to one (an effort is smoothed before it tells anything); `noise` is that
    of the averages. free_zero: a constant that nobody knows.
    """

    machine: Machine
    rows_s: FloatArray
    noise: Noise
    used: np.ndarray[tuple[int], np.dtype[np.bool_]]
    free_zero: bool = False
    every: int = 1

    def signal(self, sizes: Sizes, ideal: bool = False) -> FloatArray:
        """Noiseless readings (m,), averaged, of rows that are used."""
        clean = self.machine.clean(sizes, self.rows_s, ideal)[self.used]
        if self.every == 1:
            return clean
        whole = len(clean) // self.every * self.every
        averaged: FloatArray = clean[:whole].reshape(-1, self.every).mean(axis=1)
        return averaged

    def parts(self, sizes: Sizes, effect: str) -> FloatArray:
        """What one effect among others does to the readings (m,)."""
        without = {name: values for name, values in sizes.items() if name != effect}
        return self.signal(sizes) - self.signal(without)

    def free(self, sizes: Sizes, effect: str) -> list[FloatArray]:
        """What an effect does, and what a little more of each of its sizes would, (m,) each."""
        here = self.signal(sizes)
        columns = [self.parts(sizes, effect)]
        for name, value in sizes[effect].items():
            nudged = {**sizes[effect], name: value + NUDGE * max(abs(value), NUDGE)}
            columns.append((self.signal({**sizes, effect: nudged}) - here) / NUDGE)
        return columns

    def left(self, signal: FloatArray, columns: Sequence[FloatArray] = ()) -> FloatArray:
        """Whitened signal after what is free, (m,)."""
        free = [*columns, np.ones_like(signal)] if self.free_zero else list(columns)
        white = whitened(np.column_stack([signal, *free]), self.noise)
        target = white[:, 0]
        if free:
            target = target - white[:, 1:] @ np.linalg.lstsq(white[:, 1:], target, rcond=1e-10)[0]
        return target

    def chi2(self, signal: FloatArray, columns: Sequence[FloatArray] = ()) -> float:
        """Squared distance from nothing."""
        white = self.left(signal, columns)
        return float(white @ white)

    def rms(self, signal: FloatArray) -> float:
        """Root mean square, without its mean where that is free."""
        return float(np.std(signal) if self.free_zero else np.sqrt(np.mean(signal**2)))


def sized(
    observer: Observer,
    kind: Kind,
    drawn: Mapping[str, float],
    scale: Scale,
    ratio: float,
    least: float = 0.0,
) -> Values:
    """The effect at such a size that its root mean square is `ratio` times the noise's.

    As near as the least and the largest plausible size allow: secants from zero, damped where they
    overshoot.
    """
    target = ratio * observer.noise.scatter
    x, healthy = kind.first(scale), observer.signal({}, ideal=True)
    for step in range(8):
        values = kind.values(x, drawn, scale)
        reached = observer.rms(observer.signal({kind.effect: values}, ideal=True) - healthy)
        if reached <= 0.0:
            break
        if abs(reached / target - 1.0) < 0.03:
            break
        factor = (target / reached) ** (1.0 if step < 2 else 0.6)
        lowest = max(least, 1e-6 * kind.first(scale))
        x = float(np.clip(x * factor, lowest, kind.most(scale)))
    if kind.signed and drawn.get("sign", 1.0) < 0.0:
        x = -x
    return kind.values(x, drawn, scale)


@dataclass(frozen=True)
class Alternatives:
    """Which other effects explain one: the same in this motion, or a tie."""

    same: list[str]
    ties: list[str]
    nearest: float
    """Least chi-square that any of them leaves."""
    own: float
    """Chi-square of the effect itself as its word means it."""


def alternatives(
    observer: Observer, kinds: Sequence[Kind], scale: Scale, sizes: Sizes, effect: str
) -> Alternatives:
    """Every other kind refitted in place of an effect, the remaining ones as they are."""
    base = {name: values for name, values in sizes.items() if name != effect}
    ground = observer.signal(base, ideal=True)
    signal = observer.signal(sizes, ideal=True) - ground
    own = observer.chi2(signal)
    same, ties, nearest = [], [], own
    for kind in kinds:
        if kind.effect in sizes:
            continue
        shapes = _shapes(kind, scale, sizes.get(effect, {}))
        tried = (_left(observer, signal, ground, base, kind, scale, shape) for shape in shapes)
        left = min(tried, default=own)
        nearest = min(nearest, left)
        if left < min(SAME, OF_IT * own):
            same.append(kind.effect)
        elif left < min(TIE, OF_IT * own):
            ties.append(kind.effect)
    return Alternatives(same, ties, nearest, own)


def _shapes(kind: Kind, scale: Scale, truth: Values) -> Iterator[dict[str, float]]:
    """Values of what is drawn beside a size, over a coarse grid that has the truth's own."""
    if kind.effect in WAVES:
        periods = [truth["period"]] if "period" in truth else [0.5 * scale.length, scale.length]
        for period in periods:
            yield from ({"period": period, "phase": phase} for phase in (0.0, 0.5 * np.pi))
        return
    grids: dict[str, list[dict[str, float]]] = {
        "following_lag": [{"share": share} for share in (0.0, 1.0)],
        "stribeck_friction": [{"speed": part * scale.speed} for part in (0.1, 0.2)],
        "lost_steps": [{"time": part * scale.span} for part in (0.2, 0.35, 0.5, 0.65, 0.8)],
        "sensor_drift": [{"time_constant": part * scale.span} for part in (0.1, 0.2, 0.35)],
        "resonance": [{"damping": damping} for damping in (0.05, 0.3, 0.9)],
    }
    kept = () if "period" in truth else ("time", "damping")
    own = {name: truth[name] for name in kept if name in truth}
    for shape in grids.get(kind.effect, [{}]):
        yield {**own, **shape}


def _left(
    observer: Observer,
    signal: FloatArray,
    ground: FloatArray,
    base: Sizes,
    kind: Kind,
    scale: Scale,
    shape: Mapping[str, float],
) -> float:
    """Chi-square that a kind leaves at its best size: a secant, refitted where it ends."""
    if not _possible(kind, scale):
        return observer.chi2(signal)
    x, best = 0.3 * kind.first(scale), observer.chi2(signal)
    wave = "phase" in shape
    for number in range(REFITS):
        column = observer.signal({**base, kind.effect: kind.values(x, shape, scale)}, True) - ground
        columns = [column]
        if wave:
            other = {**shape, "phase": shape["phase"] + 0.5 * np.pi}
            values = kind.values(x, other, scale)
            columns.append(observer.signal({**base, kind.effect: values}, True) - ground)
        if not np.any(column):
            return best
        if wave or kind.effect == "lost_steps":
            return min(best, observer.chi2(signal, columns))
        before, best = best, min(best, observer.chi2(signal - column))
        if best > HOPELESS and best > 0.5 * before and number:
            return best
        factor = _factor(observer, signal, column)
        if factor <= 0.0 and not kind.signed:
            return best
        # What is drawn ends at a size; physics does not, short of a machine that cannot be.
        x = float(np.clip(x * factor, -kind.most(scale), BEYOND * kind.most(scale)))
        if x == 0.0 or abs(factor - 1.0) < 1e-5:
            return best
    return best


def _possible(kind: Kind, scale: Scale) -> bool:
    return not (kind.needs == "load" and scale.load == 0.0) and not (
        kind.needs == "steps" and scale.step == 0.0
    )


def _factor(observer: Observer, signal: FloatArray, column: FloatArray) -> float:
    left, other = observer.left(signal), observer.left(column)
    return float(left @ other) / max(float(other @ other), 1e-300)


def bound(observer: Observer, sizes: Sizes) -> dict[str, dict[str, float]]:
    """Cramer-Rao standard deviation of every size, all others free: effect -> parameter -> size.

    From central differences of the simulator's own readings, whitened by the drawn noise. Moments
    of events have no derivative and are taken as known.
    """
    free = [
        (effect, name)
        for effect, values in sizes.items()
        for name in values
        if not (effect == "lost_steps" and name == "time")
    ]
    slopes = [_slope(observer, sizes, effect, name) for effect, name in free]
    if not free:
        return {}
    white = np.column_stack([observer.left(slope) for slope in slopes])
    length = np.linalg.norm(white, axis=0)
    length[length == 0.0] = 1.0
    inverse = np.linalg.pinv((white / length).T @ (white / length), rcond=1e-12)
    found: dict[str, dict[str, float]] = {}
    deviations = np.sqrt(np.diag(inverse))
    for (effect, name), size, deviation in zip(free, length, deviations, strict=True):
        if deviation > 0.0:
            found.setdefault(effect, {})[name] = float(deviation / size)
    return found


def _slope(observer: Observer, sizes: Sizes, effect: str, name: str) -> FloatArray:
    value = sizes[effect][name]
    unit = abs(value - 1.0 if name == "scale" else value)
    step = PART * unit if unit else 1e-3
    low, high = (value - step if unit else value), value + step

    def moved(end: float) -> FloatArray:
        return observer.signal({**sizes, effect: {**sizes[effect], name: end}})

    slope: FloatArray = (moved(high) - moved(low)) / (high - low)
    return slope
