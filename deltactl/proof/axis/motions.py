"""How an axis is moved: the motions of real users, on a fine and even grid of time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
ONE_WAY = ("oneway", "tracking")
"""Motions that never turn back."""


@dataclass(frozen=True)
class Motion:
    """Where an axis (or a target) is asked to be.

    t_s, position: shape (n,), evenly spaced by `step_s`. stroke: span of the positions that are
    meant to be reached; stroke_s: what a typical move over it takes.
    """

    style: str
    step_s: float
    t_s: FloatArray
    position: FloatArray
    stroke: float
    stroke_s: float

    def at(self, times_s: FloatArray) -> FloatArray:
        """Positions at other times, straight lines between the grid's."""
        return np.interp(times_s, self.t_s, self.position)


@dataclass(frozen=True)
class Pace:
    """How long, how fast and how far."""

    seconds: float
    step_s: float
    stroke: float
    stroke_s: float
    endless: bool = False
    """Whether it may turn on and on; else a run of one way goes over one stroke in all."""


def move(style: str, pace: Pace, rng: np.random.Generator) -> Motion:
    """A motion of a style of `STYLES`; it begins with a short rest, at a place of its own."""
    t_s = np.arange(round(pace.seconds / pace.step_s)) * pace.step_s
    middle = float(rng.uniform(-0.5, 0.5)) * pace.stroke
    shape = STYLES[style](t_s, pace.stroke_s, rng)
    if style in ONE_WAY and not pace.endless:
        shape = shape / np.ptp(shape)
    return Motion(style, pace.step_s, t_s, middle + pace.stroke * shape, pace.stroke, pace.stroke_s)


def smooth_step(share: FloatArray) -> FloatArray:
    """From 0 to 1 with the least jerk (Flash and Hogan 1985, J. Neurosci. 5, 1688)."""
    s = np.clip(share, 0.0, 1.0)
    return s**3 * (10.0 - 15.0 * s + 6.0 * s**2)


def trapezoid_step(share: FloatArray) -> FloatArray:
    """From 0 to 1 with a quarter of the time to speed up and a quarter to slow down."""
    s = np.clip(share, 0.0, 1.0)
    up, down = (8.0 / 3.0) * s**2, 1.0 - (8.0 / 3.0) * (1.0 - s) ** 2
    even = (4.0 / 3.0) * (s - 0.125)
    return np.where(s < 0.25, up, np.where(s > 0.75, down, even))


def between(
    t_s: FloatArray,
    targets: FloatArray,
    takes_s: FloatArray,
    rests_s: FloatArray,
    step: Callable[[FloatArray], FloatArray] = smooth_step,
) -> FloatArray:
    """Moves from target to target; move k takes takes_s[k], then rests rests_s[k]."""
    begin = np.concatenate([[0.0], np.cumsum(takes_s + rests_s)[:-1]])
    number = np.clip(np.searchsorted(begin, t_s, side="right") - 1, 0, len(takes_s) - 1)
    share = step((t_s - begin[number]) / takes_s[number])
    path: FloatArray = targets[number] + (targets[number + 1] - targets[number]) * share
    return path


def _moves(t_s: FloatArray, least_s: float) -> int:
    return int(t_s[-1] / least_s) + 2


def _sweep(t_s: FloatArray, stroke_s: float, rng: np.random.Generator) -> FloatArray:
    """Back and forth, at constant speed but for the turns."""
    count = _moves(t_s, stroke_s)
    ends = np.where(np.arange(count + 1) % 2, 0.5, -0.5)
    return between(t_s, ends, np.full(count, stroke_s), np.zeros(count), trapezoid_step)


def _chirp(t_s: FloatArray, stroke_s: float, rng: np.random.Generator) -> FloatArray:
    """A sine that gets faster, smaller as it does."""
    low, high = 0.15 / stroke_s, 0.6 / stroke_s
    share = t_s / t_s[-1]
    phase = 2.0 * np.pi * t_s[-1] * (low * share + 0.5 * (high - low) * share**2)
    swept: FloatArray = 0.5 * np.sin(phase) * (1.0 - 0.5 * share)
    return swept


def _multisine(t_s: FloatArray, stroke_s: float, rng: np.random.Generator) -> FloatArray:
    """Five harmonics with random phases, as in identification (Swevers et al. 1997)."""
    base = 0.12 / stroke_s
    wave = np.zeros_like(t_s)
    for harmonic in range(1, 6):
        phase = rng.uniform(0.0, 2.0 * np.pi)
        wave += np.sin(2.0 * np.pi * base * harmonic * t_s + phase) / harmonic
    wave *= smooth_step(t_s / (0.5 * stroke_s))
    waves: FloatArray = 0.5 * wave / np.abs(wave).max()
    return waves


def _trapezoid(t_s: FloatArray, stroke_s: float, rng: np.random.Generator) -> FloatArray:
    """Trapezoidal profiles between ends that vary a little, with a rest at each."""
    count = _moves(t_s, stroke_s)
    ends = np.where(np.arange(count + 1) % 2, 0.5, -0.5) * rng.uniform(0.6, 1.0, count + 1)
    rests = stroke_s * rng.uniform(0.3, 1.0, count)
    return between(t_s, ends, np.full(count, stroke_s), rests, trapezoid_step)


def _random(t_s: FloatArray, stroke_s: float, rng: np.random.Generator) -> FloatArray:
    """Random targets; a third of the moves are followed by a rest."""
    count = _moves(t_s, 0.4 * stroke_s)
    targets = rng.uniform(-0.5, 0.5, count + 1)
    takes = stroke_s * rng.uniform(0.4, 1.2, count)
    rests = np.where(rng.random(count) < 0.35, stroke_s * rng.uniform(0.2, 1.0, count), 0.0)
    return between(t_s, targets, takes, rests)


def _oneway(t_s: FloatArray, stroke_s: float, rng: np.random.Generator) -> FloatArray:
    """On and on in one direction, in moves of different speed."""
    count = _moves(t_s, 0.5 * stroke_s)
    steps = rng.uniform(0.3, 1.0, count)
    takes = stroke_s * rng.uniform(0.5, 1.5, count)
    rests = np.where(rng.random(count) < 0.3, 0.5 * stroke_s, 0.0)
    targets = np.concatenate([[0.0], np.cumsum(steps)])
    return between(t_s, targets, takes, rests, trapezoid_step)


def _pick(t_s: FloatArray, stroke_s: float, rng: np.random.Generator) -> FloatArray:
    """The same few places again and again, with a dwell at each."""
    places = np.concatenate([[-0.5, 0.5], rng.uniform(-0.4, 0.4, int(rng.integers(1, 3)))])
    count = _moves(t_s, 0.8 * stroke_s)
    targets = np.resize(places, count + 1)
    dwell = np.resize(stroke_s * rng.uniform(0.3, 0.9, len(places)), count)
    return between(t_s, targets, np.full(count, 0.8 * stroke_s), dwell)


def _typed(t_s: FloatArray, stroke_s: float, rng: np.random.Generator) -> FloatArray:
    """Round numbers typed by hand: short moves, then rests as long as a person takes."""
    count = _moves(t_s, 1.5 * stroke_s)
    targets = np.round(rng.uniform(-0.5, 0.5, count + 1), 1)
    rests = stroke_s * (1.0 + rng.exponential(2.0, count))
    return between(t_s, targets, np.full(count, 0.7 * stroke_s), rests)


def _tracking(t_s: FloatArray, stroke_s: float, rng: np.random.Generator) -> FloatArray:
    """A constant slow speed, as a telescope's, over two strokes in all."""
    share: FloatArray = t_s / t_s[-1]
    followed: FloatArray = 2.0 * share * (1.0 + 0.02 * np.sin(2.0 * np.pi * share))
    return followed


STYLES: dict[str, Callable[[FloatArray, float, np.random.Generator], FloatArray]] = {
    "sweep": _sweep,
    "chirp": _chirp,
    "multisine": _multisine,
    "trapezoid": _trapezoid,
    "random": _random,
    "oneway": _oneway,
    "pick": _pick,
    "typed": _typed,
    "tracking": _tracking,
}
"""Every motion goes over about one stroke (-0.5 to 0.5), those of one way farther."""
