"""An axis that follows commands, stepper or servo, as a `RegressionPlant`.

prediction = ringing(play(lag(command)) + sum of shapes): a constant, a ratio, a droop under known
load, errors that repeat with the angle, slow drifts. What was read is in `recorded_axis`, what
may differ in `axis_regressors`, what the drive does in `drive_chain`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from deltactl.diagnosis.answer.records import NotTestable
from deltactl.diagnosis.evidence.options import EVIDENCE
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.left_over import UNKNOWN, LeftOver, Way
from deltactl.diagnosis.plants.lone.axis_regressors import (
    PLAYS,
    RATIO,
    WAVES,
    begins_of,
    impossible,
    regressors_of,
    usual_load,
    why_none_yields,
)
from deltactl.diagnosis.plants.lone.axis_shapes import AxisShapes
from deltactl.diagnosis.plants.lone.axis_starts import starts
from deltactl.diagnosis.plants.lone.drive_chain import DriveChain
from deltactl.diagnosis.plants.lone.options import COMMANDED_AXIS, LONE
from deltactl.diagnosis.plants.lone.recorded_axis import SETTLED_S, RecordedAxis
from deltactl.diagnosis.plants.regressor import DELAY, Columns, Shown, Sizes
from deltactl.models.effects import Trait, with_trait
from deltactl.models.robot import ServoAxis, StepperAxis
from deltactl.models.signals import between_rows
from deltactl.recording.tables.flat import FlatRecording

MOVES_THE_LOAD = frozenset({"ratio", *WAVES, "jump", "droop"})
"""Shapes that a load on a spring rings with."""


class CommandedAxis(RecordedAxis, LeftOver):
    """A single axis by its commands."""

    maps_places = True

    def __init__(self, robot: StepperAxis | ServoAxis, recordings: Sequence[FlatRecording]):
        super().__init__(robot, recordings)
        self.channel = self.name
        self.regressors = (*regressors_of(self), *self.unknowns())
        self._drive = DriveChain(self, begins_of(self))
        self._shapes = AxisShapes(self)

    def base(self, keys: frozenset[str], sizes: Sizes) -> FloatArray:
        """Command behind lag and play, (n,)."""
        return self._drive.behind(keys, sizes)

    def begins(self, keys: frozenset[str]) -> list[str]:
        """Where in a play, or in the reach of a friction, the first stretches begin, -1 to 1."""
        return [f"{key}.{name}" for key in sorted(keys & PLAYS) for name in begins_of(self)]

    def free(self) -> Columns:
        """The constant between command and reading where the zero is arbitrary: one a recording."""
        if self.robot.zero == "absolute":
            return super().free()
        shapes = np.stack([p.astype(float) for p in self.parts], axis=1)
        spread = COMMANDED_AXIS.free_constant_spread * self.mismatch
        return Columns(shapes, np.full(shapes.shape[1], spread))

    def columns(self, key: str, base: FloatArray, sizes: Sizes) -> Columns:
        """Shapes of one regressor around a base."""
        if key.startswith(UNKNOWN):
            return self.unknown(key)
        if key == "ringing":
            return self._drive.begun_ringing(sizes)
        if key not in MOVES_THE_LOAD or "ringing.frequency" not in sizes:
            return self._shapes.of(key, base, sizes)
        shapes = self._shapes.of(key, self._drive.before_ringing(sizes), sizes)
        return replace(shapes, values=self._drive.rung(shapes.values, sizes))

    @cached_property
    def covariates(self) -> dict[str, FloatArray]:
        """What a model error may follow, name -> (n,)."""
        found = {"position": self.commanded, "time": self.t_s}
        if not self.arrived:
            found["velocity"] = np.gradient(self.commanded, self.t_s)
            found["acceleration"] = _acceleration(self.commanded, self.t_s)
        if self.steady:
            del found["time"]
        if np.ptp(self.pull[self.rows]) > 0.0:
            found["load"] = self.pull
        if self.turns_back:
            found["direction"] = self.direction
        return found

    def ways(self) -> dict[str, Way]:
        """By direction a difference between both ways, which may change over the travel."""
        found = super().ways()
        if "time" in found:
            found["time"] = replace(found["time"], named=self._named[:, [0, 1]])
        if "acceleration" in found:
            found["acceleration"] = self._accelerated(found["acceleration"])
        if "direction" in found:
            at = (self.commanded - self.commanded[self.rows].mean()) / max(self.span, 1e-300)
            powers = np.stack([np.ones_like(at), at, at**2], axis=1)
            given = self.direction[:, None] * powers
            found["direction"] = replace(found["direction"], given=given)
        return found

    def _accelerated(self, way: Way) -> Way:
        """No named effect is a function of it, and a motion back and forth accelerates against its
        place: there it may be a ratio as well. A straight line between two rows is off by an eighth
        of the square of their time apart, and a delay by half of its own square, by whether it is
        dead time or a time constant.
        """
        usual = float(np.sqrt(np.mean(way.along[self.rows] ** 2)))
        apart = EVIDENCE.tolerated * self.readings.period_s**2 / 8.0
        off = usual * (apart + 0.5 * max(self._late_s, 0.0) ** 2)
        others = self._named[:, [0, *range(2, self._named.shape[1])]]
        return replace(way, gives_way=False, as_built=off, named=others)

    @cached_property
    def _named(self) -> FloatArray:
        """A constant, the travel, the load and a small lag (the command's own speed), (n, j).

        A lag is not negative: nothing named explains a reading that is ahead of its command.
        """
        return self._and_late if self._late_s > 0.0 and not self.arrived else self._and_late[:, :-1]

    @cached_property
    def _and_late(self) -> FloatArray:
        named = [np.ones_like(self.t_s), self.commanded]
        if np.ptp(self.pull[self.rows]) > 0.0:
            named.append(self.pull)
        return np.stack([*named, -np.gradient(self.commanded, self.t_s)], axis=1)

    @cached_property
    def _late_s(self) -> float:
        """How late the readings are, as far as constant, ratio and load do not explain them."""
        off = (self.observed - self.nominal)[self.rows]
        return float(np.linalg.lstsq(self._and_late[self.rows], off, rcond=1e-10)[0][-1])

    @cached_property
    def unsampled(self) -> FloatArray:
        """A late axis shows where the command was between two samples, (n,): as late as usual.

        Rows that are read long after each move show where it ends.
        """
        if self.readings.period_s > SETTLED_S:
            return np.zeros_like(self.commanded)
        share = min(LONE.lag_spread_s / self.readings.period_s, 1.0)
        return share * between_rows(self.commanded)

    def spanned(self, name: str) -> FloatArray:
        """Named shapes (n, j) that a spline term may not take the place of, unless its way says."""
        return self._named

    def places(self, keys: frozenset[str], sizes: Sizes) -> FloatArray:
        """The place that the axis reaches, rather than the one commanded, (n,)."""
        return self.base(keys, sizes)

    def spread_of(self, name: str, shapes: int) -> float:
        """Half of what reading and prediction are apart."""
        return LONE.unknown_of_mismatch * self.mismatch

    def pieces(self, name: str) -> int:
        """Twice as many over time, in which anything may come and go; fewer of a short table."""
        most = COMMANDED_AXIS.axis_pieces * (2 if name == "time" else 1)
        stood_on = len(self.rows) // LONE.rows_a_piece
        return int(np.clip(stood_on, LONE.fewest_pieces, most))

    def adopt(self, trained: CommandedAxis) -> None:
        """Travel, spread and map in detail of the recording that sizes were found on."""
        super().adopt(trained)
        self.span, self.mismatch = trained.span, trained.mismatch

    def shown(self, key: str) -> Sequence[Shown]:
        """Parameters of the contract's effects, in the axis' own unit."""
        unit = self.unit
        stiffness = "N/m" if unit == "m" else "N m/rad"
        lost = max(self.rad_per_step, 1e-300)
        table = {
            "offset": [Shown("angle", unit, lambda v: v["angle"])],
            "ratio": [Shown("scale", "1", lambda v: 1.0 + v["scale"], nothing=1.0)],
            "lag": DELAY,
            "droop": [Shown("stiffness", stiffness, lambda v: 1.0 / v["1/stiffness"])],
            "gear": [
                Shown("amplitude", unit, lambda v: np.hypot(v["sine"], v["cosine"])),
                # At the output, which a ratio that is off moves farther than the command says.
                Shown("period", unit, lambda v: self.span * (1.0 + v.get(RATIO, 0.0)) / v["waves"]),
                Shown("phase", "rad", lambda v: np.arctan2(v["cosine"], v["sine"])),
                Shown("amplitude_2", unit, lambda v: np.hypot(v["sine2"], v["cosine2"])),
                Shown("phase_2", "rad", lambda v: np.arctan2(v["cosine2"], v["sine2"])),
            ],
            "jump": [Shown("steps", "microsteps", lambda v: -v["shift"] / lost),
                     Shown("time", "s", lambda v: v["moment"])] if self.rad_per_step else [],
            "speed": [Shown("limit", f"{unit}/s", lambda v: v["limit"], nothing=math.inf)],
            "ringing": [
                Shown("frequency", "Hz", lambda v: v["frequency"]),
                Shown("damping", "1", lambda v: v["damping"]),
            ],
        }  # fmt: skip
        table["slow"] = table["teeth"] = table["gear"]
        load = usual_load(self)
        table["play"] = table["friction"] = [
            Shown("width", unit, lambda v: v["width"]),
            Shown("build_up", "1", lambda v: v.get("build_up", 0.0 * v["width"]), as_without=0.0),
        ]
        table["rubbing"] = [
            Shown("width", unit, lambda v: v["width"] + load * v["grip"]),
            Shown("unloaded", "1", lambda v: _share(v["width"], load * v["grip"]), as_without=1.0),
        ]
        return table.get(key, [])

    def not_testable(self) -> list[NotTestable]:
        """Effects that need a known load, or a zero that means something."""
        yields = with_trait(Trait.UNDER_LOAD)
        arbitrary = "the zero of the reading is arbitrary"
        reasons = dict.fromkeys(yields, why_none_yields(self))
        reasons |= dict.fromkeys(with_trait(Trait.ZERO), arbitrary)
        if self.arrived:
            apart = "rows are further apart than a drive takes to arrive"
            reasons |= dict.fromkeys(with_trait(Trait.DRIVE_DELAY), apart)
        if not self.turns_back:
            one_way = "the command never turns back: there it is a constant"
            reasons |= dict.fromkeys(with_trait(Trait.HYSTERESIS), one_way)
        if self.steady:
            one_speed = "the axis turns at one speed and never back: there it is a constant"
            reasons |= dict.fromkeys(with_trait(Trait.DRIVE_DELAY, Trait.HYSTERESIS), one_speed)
        offered = {r.effect for r in self.regressors}
        same = {same.effect for r in self.regressors for same in r.equivalents}
        offered |= same - {*yields}  # which may be meant, but has no size without a load
        left = {name: why for name, why in reasons.items() if name not in offered}
        return [NotTestable.of(name, "axis", why) for name, why in left.items()]

    def impossible(
        self, keys: frozenset[str], sizes: Sizes, linear: Mapping[str, FloatArray]
    ) -> bool:
        """Sizes at a bound of their regressor, play below a step of the reading."""
        return super().impossible(keys, sizes, linear) or impossible(self, keys, sizes, linear)

    def starts(self, key: str, residual: FloatArray) -> Sequence[dict[str, float]]:
        """Where to start the nonlinear sizes of a regressor."""
        return starts(self, key, residual) or super().starts(key, residual)


def _share(part: FloatArray, rest: FloatArray) -> FloatArray:
    """Shares of a part in it and the rest."""
    share: FloatArray = part / np.maximum(part + rest, 1e-300)
    return share


def _acceleration(places: FloatArray, t_s: FloatArray) -> FloatArray:
    """Second derivatives (n,) by the neighbours of each row: its own rounding is part of its error,
    which must not follow it.
    """
    speed, middle = np.diff(places) / np.diff(t_s), 0.5 * (t_s[1:] + t_s[:-1])
    inner = (speed[3:] - speed[:-3]) / (middle[3:] - middle[:-3])
    padded: FloatArray = np.pad(inner, 2, mode="edge") if len(inner) else np.zeros_like(t_s)
    return padded
