"""What an axis does with its command, part by part: lag, top speed, friction, play, ringing."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, lru_cache

import numpy as np

from deltactl.diagnosis.observations.readings import BoolArray, FloatArray
from deltactl.diagnosis.plants.lone.options import COMMANDED_AXIS
from deltactl.diagnosis.plants.lone.recorded_axis import RecordedAxis
from deltactl.diagnosis.plants.regressor import Columns, Sizes
from deltactl.models.effects.axis_play import loose
from deltactl.models.effects.speed_limit import rate_limited
from deltactl.models.signals import AnyArray, late, linear, slopes_of

STAGES = ("lag", "speed", "friction", "rubbing", "play", "ringing")
"""Parts of the chain from the command to the axis, in their order."""


class DriveChain:
    """The prediction of an axis behind its lag and play, for sizes in which it is not linear."""

    def __init__(self, axis: RecordedAxis, begins: Sequence[str]):
        """begins: names of the sizes that say where in the play the first stretches begin."""
        self._axis, self._begins = axis, begins
        self._kept: dict[tuple[object, ...], FloatArray] = {}
        self._rings = lru_cache(maxsize=1)(self._ringing)
        self._begun = lru_cache(maxsize=1)(self._rings_on)

    def behind(self, keys: frozenset[str], sizes: Sizes) -> FloatArray:
        """Command behind lag and play, (n,)."""
        stages = [key for key in STAGES if key in keys]
        known = tuple(
            (name, sizes[name]) for name in sorted(sizes) if name.partition(".")[0] in stages
        )
        return self._behind(tuple(stages), known)

    def _behind(self, stages: tuple[str, ...], at: tuple[tuple[str, float], ...]) -> FloatArray:
        """The same, kept for the fits that pass here again: most move one size at a time."""
        if not stages:
            return self._axis.nominal
        if (stages, at) not in self._kept:
            last = stages[-1]
            earlier = tuple((n, value) for n, value in at if not n.startswith(f"{last}."))
            driven = self._stage(last, self._behind(stages[:-1], earlier), dict(at))
            if len(self._kept) >= COMMANDED_AXIS.most_kept:
                del self._kept[next(iter(self._kept))]
            self._kept[stages, at] = driven
        return self._kept[stages, at]

    def _stage(self, key: str, driven: FloatArray, sizes: Sizes) -> FloatArray:
        """What one part of the chain makes of its input, (n,)."""
        if key == "lag":
            axis, dead_s, time_s = self._axis, sizes["lag.dead_time"], sizes["lag.time"]
            return late(
                driven, self._slopes, axis.t_s, axis.readings.stretch_start_s, dead_s, time_s
            )
        if key == "speed":
            limit, before = sizes["speed.limit"], float(driven[0])
            return rate_limited(driven, self._axis.readings.step_s, limit, before)
        if key == "ringing":
            return self.rung(driven[:, None], sizes)[:, 0]
        pull = self._axis.pull if key == "play" else np.zeros(len(driven))
        return self._played(driven, sizes, key, pull)

    @cached_property
    def _slopes(self) -> FloatArray:
        """Slopes of the command, which comes to the first of the stages."""
        axis = self._axis
        return slopes_of(axis.nominal, axis.t_s, axis.readings.step_s)

    def _played(self, driven: FloatArray, sizes: Sizes, key: str, pull: FloatArray) -> FloatArray:
        starts = np.zeros(int(np.count_nonzero(self._axis.readings.fresh)))
        known = [sizes[f"{key}.{name}"] for name in self._begins if f"{key}.{name}" in sizes]
        starts[: len(known)] = known[: len(starts)]
        width: float | FloatArray = sizes[f"{key}.width"]
        if key == "rubbing":
            width = width + sizes["rubbing.grip"] * np.abs(self._axis.pull)
        fresh, before = self._axis.readings.fresh, (float(driven[0]), float(driven[0]))
        return loose(driven, fresh, width, starts, pull, before, sizes.get(f"{key}.build_up", 0.0))

    def before_ringing(self, sizes: Sizes) -> FloatArray:
        """Command behind all but the load that rings, (n,)."""
        known = {name.partition(".")[0] for name in sizes}
        return self.behind(frozenset(known - {"ringing"}), sizes)

    def rung(self, driven: FloatArray, sizes: Sizes) -> FloatArray:
        """A mass on a damped spring whose damper moves along: see models.effects.resonance.

        driven: what moves its foot, a column each, (n, k).
        """
        per_s, goes_on, gain, kept, bent = self._rings(_pole(sizes))
        speed = np.zeros(driven.shape)
        np.multiply(driven[1:] - driven[:-1], per_s[1:], out=speed[1:])
        change = (speed[1:] - speed[:-1]) * goes_on[1:]
        pushed = kept * speed
        pushed[1:] += bent[1:] * change
        pushed[:-1] += bent[:-1] * change
        rung: FloatArray = driven + linear(gain, pushed, np.zeros(driven.shape[1], complex)).real
        return rung

    def _ringing(self, pole: complex) -> tuple[FloatArray, BoolArray, AnyArray, AnyArray, AnyArray]:
        """One over each row's step, whether it and the one before it are known (n, 1), the
        share of its state that a load keeps (n,), and what its foot's speed and half the change of
        that speed do to it, exact for a parabola (n, 1).
        """
        step = self._axis.readings.step_s[:, None]
        moves, decay = step > 0.0, np.exp(pole * step)
        per_s: FloatArray = np.divide(1.0, step, out=np.zeros(step.shape), where=moves)
        share, kept = 1.0 - 1j * pole.real / pole.imag, np.where(moves, (decay - 1.0) / pole, 0.0)
        bent = kept / pole * per_s - np.where(moves, 0.5 * (decay + 1.0) / pole, 0.0)
        goes_on = moves & np.roll(moves, 1, axis=0)
        return per_s, goes_on, np.where(moves, decay, 0.0)[:, 0], -share * kept, -0.5 * share * bent

    def begun_ringing(self, sizes: Sizes) -> Columns:
        """How a load rings that was moving where a stretch begins: cosine and sine of each."""
        return self._begun(_pole(sizes))

    def _rings_on(self, pole: complex) -> Columns:
        axis = self._axis
        since_s = axis.t_s - axis.readings.stretch_start_s
        stretch = np.cumsum(axis.readings.fresh) - 1
        first = np.flatnonzero(axis.readings.fresh)[: len(self._begins)]
        rings = np.exp(pole * since_s)[:, None] * (stretch[:, None] == np.arange(len(first)))
        spread = np.maximum(np.abs(self._slopes[first]) / abs(pole), 1e-300)
        shapes = np.concatenate([rings.real, rings.imag], axis=1)
        return Columns(shapes, np.tile(spread, 2), lasts=False)


def _pole(sizes: Sizes) -> complex:
    damping = sizes["ringing.damping"]
    return complex(-damping, np.sqrt(1.0 - damping**2)) * 2.0 * np.pi * sizes["ringing.frequency"]
