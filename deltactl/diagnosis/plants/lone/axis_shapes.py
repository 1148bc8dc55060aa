"""Shapes of what may differ on an axis that follows commands, a column a size."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.lone.axis_regressors import WAVES
from deltactl.diagnosis.plants.lone.options import COMMANDED_AXIS, FILE_SPREADS, LONE
from deltactl.diagnosis.plants.lone.recorded_axis import RecordedAxis
from deltactl.diagnosis.plants.regressor import Columns, Sizes
from deltactl.models.effects import Trait, has
from deltactl.models.signals import late, slopes_of

RATIO_SPREAD = {
    "stepper_axis": FILE_SPREADS.stepper_ratio_share,
    "servo_axis": FILE_SPREADS.servo_ratio_share,
}
"""By kind of machine."""


class AxisShapes:
    """Columns (n, k) with their spreads, around a prediction (n,)."""

    def __init__(self, axis: RecordedAxis):
        self._axis = axis
        self._drooped: tuple[float, Columns] | None = None

    def of(self, key: str, base: FloatArray, sizes: Sizes) -> Columns:
        """Shapes of one regressor around a base; none of one whose sizes are all nonlinear."""
        if key == "offset":
            return self._homes
        if key == "ratio":
            shape = (
                base
                if self._axis.robot.zero == "absolute"
                else base - np.mean(base[self._axis.rows])
            )
            return Columns.of(shape, RATIO_SPREAD[self._axis.robot.kind], "scale")
        if key == "droop":
            return self._droop(sizes.get("lag.time", 0.0) + self._known_late_s)
        if key in WAVES:
            return self._waves(base, sizes[f"{key}.waves"])
        if key == "drift":
            return self._bend
        if key == "jump":
            after = (self._axis.t_s >= sizes["jump.moment"]).astype(float)
            return Columns.of(after, self._axis.mismatch, "shift")
        return Columns.none(len(base))

    def _droop(self, late_s: float) -> Columns:
        """Kept for one delay: most points of a fit share it."""
        if self._drooped is None or self._drooped[0] != late_s:
            pull = self._pulled(late_s)
            self._drooped = (late_s, Columns.of(pull, self._yielding, "1/stiffness"))
        return self._drooped[1]

    def _pulled(self, late_s: float) -> FloatArray:
        """What pulls, (n,), as late as the drive gives way to it."""
        axis = self._axis
        if late_s <= 0.0:
            return axis.pull
        return late(
            axis.pull, self._pull_slopes, axis.t_s, axis.readings.stretch_start_s, 0.0, late_s
        )

    @cached_property
    def _pull_slopes(self) -> FloatArray:
        return slopes_of(self._axis.pull, self._axis.t_s, self._axis.readings.step_s)

    @cached_property
    def _known_late_s(self) -> float:
        lags = [one for one in self._axis.robot.effects if has(one.effect, Trait.DRIVE_DELAY)]
        return float(sum(float(np.asarray(one.parameters["time"])) for one in lags))

    @cached_property
    def _homes(self) -> Columns:
        """A constant; of several recordings each, for a machine is homed anew on another day."""
        axis = self._axis
        own = [p - float(np.mean(p[axis.rows])) for p in axis.parts[1:]]
        shapes = np.stack([np.ones(len(axis.t_s)), *own], axis=1)
        names = ("angle", *(f"angle_{n}" for n in range(2, len(own) + 2)))
        return Columns(shapes, np.full(len(names), axis.mismatch), names)

    @cached_property
    def _bend(self) -> Columns:
        """A drift that bends slowly: second and third power of time, less a constant and a line."""
        scaled = (self._axis.t_s - self._axis.t_s.mean()) / max(
            float(np.ptp(self._axis.t_s)), 1e-300
        )
        line = np.stack([np.ones_like(scaled), scaled], axis=1)
        bent = np.stack([scaled**2, scaled**3], axis=1)
        share, *_ = np.linalg.lstsq(line[self._axis.rows], bent[self._axis.rows], rcond=None)
        shapes = bent - line @ share
        return Columns(shapes / np.std(shapes, axis=0), np.full(2, self._axis.mismatch))

    @cached_property
    def _yielding(self) -> float:
        pull = self._axis.pull[self._axis.rows]
        droop = LONE.size_of_mismatch * self._axis.mismatch
        return droop / max(float(np.std(pull)), 1e-300)

    def _waves(self, base: FloatArray, waves: float) -> Columns:
        """First and second harmonic of a wave that repeats `waves` times over the travel."""
        angle = 2.0 * np.pi * waves / self._axis.span * base
        sine, cosine = np.sin(angle), np.cos(angle)
        shapes = np.stack([sine, cosine, 2.0 * sine * cosine, 1.0 - 2.0 * sine**2], axis=1)
        second = COMMANDED_AXIS.second_harmonic
        spread = self._axis.mismatch * np.array([1.0, 1.0, second, second])
        return Columns(shapes, spread, ("sine", "cosine", "sine2", "cosine2"))
