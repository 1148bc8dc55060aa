"""Shapes of the forces that may be missing on an axis driven by effort, a column a size."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from deltactl.diagnosis.observations.inverse_dynamics import Motion
from deltactl.diagnosis.observations.readings import FloatArray, IntArray
from deltactl.diagnosis.plants.lone.options import FILE_SPREADS, FORCED_AXIS
from deltactl.diagnosis.plants.regressor import Columns, Size, Sizes
from deltactl.models.effects.stribeck_friction import SPEEDS, STARTS, WITHIN, Falls, falls


@dataclass(eq=False)
class SlowFriction:
    """Friction of 1 of slow motion only, by the speed within which it falls off."""

    motion: Motion
    direction: FloatArray

    @cached_property
    def speeds(self) -> Falls:
        """From the least to the largest at which friction may have come down."""
        return Falls(*(share * self.motion.top_speed for share in SPEEDS))

    def differs(self, gain: str) -> dict[str, Any]:
        """What its regressor is; gain: name of the drive's."""
        top = self.motion.top_speed
        (slow, fast), (low, high) = SPEEDS, WITHIN
        within = (low * top, high * top)
        speed = Size("speed", "flat", top, slow * top, fast * top, 2e-3 * top, within=within)
        starts = tuple((share * top,) for share in STARTS)
        brakes = {"positive": ("torque",), "above": 0.0, "measured_by": gain}
        return {"sizes": (speed,), "starts": starts, **brakes}

    @cached_property
    def shapes(self) -> FloatArray:
        """The friction (n, m) for each speed of a table."""
        share = falls(self.motion.turning[:, None], self.speeds.speeds)
        return self.motion.low_passed(self.direction[:, None] * share)


@dataclass(eq=False)
class ForceShapes:
    """Columns (n, k) with their spreads, low-passed like the effort.

    direction: (n,) from -1 to 1. force: what the drive gives, and pulled: what loads and gravity
    give, both low-passed, (n,). rows: samples that count. turns: whether the axis is rotary.
    """

    motion: Motion
    direction: FloatArray
    force: FloatArray
    pulled: FloatArray
    rows: IntArray
    inertia: float
    turns: bool

    def of(self, key: str, sizes: Sizes) -> Columns:
        """Forces of one regressor at the time of the motion."""
        if key == "spring":
            return self._spring
        return self._stribeck(sizes["stribeck.speed"]) if key == "stribeck" else self.linear[key]

    @cached_property
    def size(self) -> float:
        """How large forces are here, by their root mean square: a constant one is a force too."""
        moved = self._accelerated - self.pulled
        either = [force[self.rows] for force in (self.force, moved)]
        return max(*(float(np.sqrt(np.mean(force**2))) for force in either), 1e-300)

    @cached_property
    def slow(self) -> SlowFriction:
        """Friction that falls with speed."""
        return SlowFriction(self.motion, self.direction)

    @cached_property
    def linear(self) -> dict[str, Columns]:
        """Forces that a size scales, by their regressor."""
        motion = self.motion
        table = {
            "friction": (motion.low_passed(self.direction), self.size, "torque"),
            "viscous": (motion.velocity, self.size / motion.top_speed, "coefficient"),
            "inertia": (motion.acceleration, FILE_SPREADS.inertia_share * self.inertia, "inertia"),
            "offset": (np.ones(len(motion.position)), self.size, "offset"),
            "gain": (self._accelerated - self.pulled, FILE_SPREADS.gain_share, "scale"),
        }
        return {key: Columns.of(*one) for key, one in table.items()}

    @property
    def _accelerated(self) -> FloatArray:
        return self.motion.acceleration * self.inertia

    @cached_property
    def _stribeck(self) -> Callable[[float], Columns]:
        """Friction that falls off within a speed; most points of a fit share it."""
        return lru_cache(maxsize=8)(self._falling)

    def _falling(self, speed: float) -> Columns:
        weights = self.slow.speeds.weights(speed)
        spread = FORCED_AXIS.stribeck_of_size * self.size
        return Columns.of(self.slow.shapes @ weights, spread, "torque")

    @cached_property
    def _spring(self) -> Columns:
        """A force by position that no effect is: a spring or cable, a weight the file leaves out.

        In motions to and fro it looks like inertia, so it is chosen together with the named ones.
        """
        shapes = self._by_place(len(self.middle) > 1) - self.middle
        sizes = np.maximum(np.std(shapes[self.rows], axis=0), 1e-300)
        return Columns(shapes, FORCED_AXIS.stribeck_of_size * self.size / sizes)

    @cached_property
    def middle(self) -> FloatArray:
        """Middle of a force by position, (1,); of its sine and cosine, (2,), over a wide range."""
        far = self.turns and np.ptp(self.motion.position[self.rows]) > FORCED_AXIS.weighed_rad
        return np.asarray(self._by_place(bool(far))[self.rows].mean(axis=0))

    def _by_place(self, far: bool) -> FloatArray:
        at = self.motion.position
        return np.stack([np.sin(at), np.cos(at)] if far else [at], axis=1)
