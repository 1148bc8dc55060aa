"""What an axis does with its command, part by part: lag, top speed, friction, play, ringing."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from deltactl.diagnosis.observations.readings import BoolArray, FloatArray
from deltactl.diagnosis.plants.lone.options import COMMANDED_AXIS
from deltactl.diagnosis.plants.lone.recorded_axis import RecordedAxis
from deltactl.diagnosis.plants.regression import Columns, Sizes
from deltactl.models.effects.axis_play import loose
from deltactl.models.effects.speed_limit import rate_limited
from deltactl.models.signals import late, linear, slopes_of

ComplexArray = NDArray[np.complex128]
STAGES = ("lag", "speed", "friction", "rubbing", "play", "ringing")
"""Parts of the chain from the command to the axis, in their order."""


class DriveChain:
    """The prediction of an axis behind its lag and play, for sizes in which it is not linear."""

    def __init__(self, axis: RecordedAxis, begins: Sequence[str]):
        """begins: names of the sizes that say where in the play the first stretches begin."""
        self._axis, self._begins = axis, begins
        self._kept: dict[tuple[object, ...], FloatArray] = {}
        self._rings: tuple[complex, tuple[ComplexArray, ...]] | None = None
        self._begun: tuple[complex, Columns] | None = None

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
            return late(driven, self._slopes, axis.t_s, axis.stretch_start_s, dead_s, time_s)
        if key == "speed":
            limit, before = sizes["speed.limit"], float(driven[0])
            return rate_limited(driven, self._axis.step_s, limit, before)
        if key == "ringing":
            return self.rung(driven[:, None], sizes)[:, 0]
        pull = self._axis.pull if key == "play" else np.zeros(len(driven))
        return self._played(driven, sizes, key, pull)

    @cached_property
    def _slopes(self) -> FloatArray:
        """Slopes of the command, which comes to the first of the stages."""
        axis = self._axis
        return slopes_of(axis.nominal, axis.t_s, axis.step_s)

    def _played(self, driven: FloatArray, sizes: Sizes, key: str, pull: FloatArray) -> FloatArray:
        starts = np.zeros(int(np.count_nonzero(self._axis.readings.fresh)))
        known = [sizes[f"{key}.{name}"] for name in self._begins if f"{key}.{name}" in sizes]
        starts[: len(known)] = known[: len(starts)]
        width: float | FloatArray = sizes[f"{key}.width"]
        if key == "rubbing":
            width = width + sizes["rubbing.grip"] * np.abs(self._axis.pull)
        return loose(driven, self._axis.readings.fresh, width, starts, pull, float(driven[0]))

    def before_ringing(self, sizes: Sizes) -> FloatArray:
        """Command behind all but the load that rings, (n,)."""
        known = {name.partition(".")[0] for name in sizes}
        return self.behind(frozenset(known - {"ringing"}), sizes)

    def rung(self, driven: FloatArray, sizes: Sizes) -> FloatArray:
        """A mass on a damped spring whose damper moves along: see models.effects.resonance.

        driven: what moves its foot, a column each, (n, k).
        """
        gain, kept, bent = self._ringing(_pole(sizes), sizes["ringing.damping"])
        speed = np.zeros(driven.shape)
        np.multiply(driven[1:] - driven[:-1], self._per_s[1:], out=speed[1:])
        change = (speed[1:] - speed[:-1]) * self._go_on[1:]
        pushed = kept * speed
        pushed[1:] += bent[1:] * change
        pushed[:-1] += bent[:-1] * change
        state = linear(gain, pushed, np.zeros(driven.shape[1], complex))
        rung: FloatArray = driven + state.real
        return rung

    @cached_property
    def _per_s(self) -> FloatArray:
        """One over the time since the row before, 0 where a stretch begins, (n, 1)."""
        step = self._axis.step_s[:, None]
        per_s: FloatArray = np.divide(1.0, step, out=np.zeros(step.shape), where=step > 0.0)
        return per_s

    @cached_property
    def _go_on(self) -> BoolArray:
        """Rows before which the motion is known for a step, and for one more, (n, 1)."""
        moves = self._per_s > 0.0
        return moves & np.roll(moves, 1, axis=0)

    def _ringing(self, pole: complex, damping: float) -> tuple[ComplexArray, ...]:
        """Share of its state that a load keeps in each row's step, (n,), and what its foot's speed
        and half the change of that speed do to it, (n, 1): exact for a parabola.
        """
        if self._rings is None or self._rings[0] != pole:
            share = 1.0 + 1j * damping / np.sqrt(1.0 - damping**2)
            moves, decay = self._per_s[:, 0] > 0.0, np.exp(pole * self._axis.step_s)
            kept = np.where(moves, (decay - 1.0) / pole, 0.0)
            bent = kept / pole * self._per_s[:, 0] - np.where(
                moves, 0.5 * (decay + 1.0) / pole, 0.0
            )
            gain = np.where(moves, decay, 0.0)
            self._rings = pole, (gain, -share * kept[:, None], -0.5 * share * bent[:, None])
        return self._rings[1]

    def begun_ringing(self, sizes: Sizes) -> Columns:
        """How a load rings that was moving where a stretch begins: cosine and sine of each."""
        pole = _pole(sizes)
        if self._begun is None or self._begun[0] != pole:
            self._begun = pole, self._rings_on(pole)
        return self._begun[1]

    def _rings_on(self, pole: complex) -> Columns:
        axis = self._axis
        since_s = axis.t_s - axis.stretch_start_s
        stretch = np.cumsum(axis.readings.fresh) - 1
        first = np.flatnonzero(axis.readings.fresh)[: len(self._begins)]
        rings = np.exp(pole * since_s)[:, None] * (stretch[:, None] == np.arange(len(first)))
        spread = np.maximum(np.abs(self._slopes[first]) / abs(pole), 1e-300)
        return Columns(np.concatenate([rings.real, rings.imag], axis=1), np.tile(spread, 2))


def _pole(sizes: Sizes) -> complex:
    damping = sizes["ringing.damping"]
    return complex(-damping, np.sqrt(1.0 - damping**2)) * 2.0 * np.pi * sizes["ringing.frequency"]
