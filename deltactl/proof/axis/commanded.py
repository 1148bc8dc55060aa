"""An axis that follows commands: loop -> motor -> gear -> axis -> encoder."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from deltactl.proof.axis.drives import DeadBand, PositionLoop, delayed, play, ringing, wound_up
from deltactl.proof.axis.motions import FloatArray, Motion

Values = Mapping[str, float]
Sizes = Mapping[str, Values]
"""What is hidden: effect or oddity -> parameter -> size in the contract's units."""
STIFFEST_TURNS = 0.12
"""Most turns of the dead band's spring in one step of the simulation."""


@dataclass(frozen=True)
class CommandedAxis:
    """The drive that has no fault follows exactly; faults act where they do in a machine.

    ideal: friction and play without the dynamics of bristles and masses, gear errors of one
    harmonic: what the vocabulary's words mean, for an ideal observer.
    load: pull towards larger positions on the grid of the motion, zero where there is none.
    """

    motion: Motion
    step_size: float = 0.0
    """Position of one microstep; 0 where commands are positions."""
    load: FloatArray = field(default_factory=lambda: np.zeros(1))
    neighbour: FloatArray = field(default_factory=lambda: np.zeros(1))
    """Motion of another axis of the machine over the same time, -0.5 to 0.5, not recorded."""
    slip: float = 0.08
    """Motion over which a bearing's friction builds up, in widths."""
    second: float = 0.15
    """Second harmonic of a gear's error over the first: its seat is oval as well as eccentric."""
    start: float = 0.3

    def clean(self, sizes: Sizes, rows_s: FloatArray, ideal: bool = False) -> FloatArray:
        """Noiseless readings (n,) at the rows' true times."""
        motion = self.motion
        at = self._axis(self._motor(sizes), sizes, ideal)
        late_s = sizes.get("sensor_latency", {}).get("time", 0.0)
        # On the grid, where a gear's error is, too: between its points both are alike.
        read = at + _wave(at, sizes.get("encoder_error"), 0.0)
        return np.interp(rows_s - late_s, motion.t_s, read)

    def command(self, rows_s: FloatArray) -> FloatArray:
        """What is recorded of the command, in whole microsteps where it is counted in them."""
        asked = self.motion.at(rows_s)
        return np.round(asked / self.step_size) if self.step_size else asked

    def _motor(self, sizes: Sizes) -> FloatArray:
        motion = self.motion
        asked, step_s = motion.position, motion.step_s
        if self.step_size:
            asked = self.step_size * np.round(asked / self.step_size)
        lag = sizes.get("following_lag", {})
        asked = delayed(asked, motion.t_s, lag.get("dead_time", 0.0))
        for loop in _loops(sizes):
            asked = loop.follow(asked, step_s)
        lost = sizes.get("lost_steps")
        if lost:
            asked = asked - np.where(motion.t_s >= lost["time"], lost["steps"] * self.step_size, 0)
        return asked

    def _axis(self, motor: FloatArray, sizes: Sizes, ideal: bool) -> FloatArray:
        motion = self.motion
        warm = sizes.get("warming_ratio", {"share": 0.0, "time": 1.0})
        grown = 1.0 - warm["share"] * np.expm1(-motion.t_s / warm["time"])
        at = motor * sizes.get("gear_ratio", {}).get("scale", 1.0) * grown
        at = self._rubbed(at, sizes, ideal)
        at = at + _wave(at, sizes.get("transmission_error"), 0.0 if ideal else self.second)
        if "joint_compliance" in sizes:
            at = at + self.load / sizes["joint_compliance"]["stiffness"]
        if "coupling" in sizes:
            at = at + sizes["coupling"]["size"] * self.neighbour
        if "elastic_cable" in sizes:
            at = at - sizes["elastic_cable"]["size"] * _cable(at, motion.stroke)
        at = at + sizes.get("home_offset", {}).get("angle", 0.0)
        if "resonance" in sizes:
            rings = sizes["resonance"]
            at = ringing(at, motion.step_s, rings["frequency"], rings["damping"])
        axis: FloatArray = at
        return axis

    def _rubbed(self, at: FloatArray, sizes: Sizes, ideal: bool) -> FloatArray:
        if "gear_backlash" in sizes:
            at = self._loose(at, sizes["gear_backlash"]["width"], ideal)
        if "joint_friction" in sizes:
            width = sizes["joint_friction"]["width"]
            at = self._wound(at, width, abs(width), ideal)
        if "growing_friction" in sizes:
            width = sizes["growing_friction"]["width"]
            share = (self.motion.position - self.motion.position.min()) / self.motion.stroke
            at = self._wound(at, width * np.clip(share, 0.0, 1.0) ** 2, abs(width), ideal)
        return at

    def _wound(
        self, at: FloatArray, width: FloatArray | float, most: float, ideal: bool
    ) -> FloatArray:
        if ideal or most == 0.0:
            return play(at, width, self.start)
        return wound_up(at, width, self.slip * most, self.start)

    def _loose(self, at: FloatArray, width: float, ideal: bool) -> FloatArray:
        """By two masses where the steps are fine enough for a stiff spring.

        The bearing holds the load where it was pushed: it stops within a twentieth of the width
        from the fastest speed. What it winds the spring up by is lost motion like the band itself,
        so that both together are the width.
        """
        step_s, width = self.motion.step_s, abs(width)
        omega = 2.0 * np.pi * STIFFEST_TURNS / step_s
        fastest = float(np.abs(np.diff(self.motion.position)).max()) / step_s
        hardest = float(np.abs(np.diff(self.motion.position, 2)).max()) / step_s**2
        rub = max(1.5 * hardest, 10.0 * fastest**2 / max(width, 1e-12))
        wound = 2.0 * rub / omega**2
        if ideal or wound > 0.05 * width:
            return play(at, width, self.start)
        band = DeadBand(width - wound, STIFFEST_TURNS / step_s, 0.7, rub)
        return band.follow(at, step_s, self.start)


def _loops(sizes: Sizes) -> list[PositionLoop]:
    """Those of the drive, one for each thing that is wrong with it."""
    loops = []
    lag = sizes.get("following_lag", {}).get("time", 0.0)
    if lag > 0.0:
        loops.append(PositionLoop(lag))
    if "speed_limit" in sizes:
        loops.append(PositionLoop(1e-3, 1.0, speed_limit=sizes["speed_limit"]["limit"]))
    if "lag_by_direction" in sizes:
        drawn = sizes["lag_by_direction"]
        loops.append(PositionLoop(drawn["time"], 0.0, drawn["time"] * drawn["back"]))
    if "overshoot" in sizes:
        drawn = sizes["overshoot"]
        loops.append(PositionLoop(drawn["time"], 1.0 + drawn["extra"]))
    return loops


def _wave(at: FloatArray, wave: Values | None, second: float) -> FloatArray:
    if not wave:
        return np.zeros_like(at)
    turns = 2.0 * np.pi * at / wave["period"] + wave.get("phase", 0.0)
    error: FloatArray = wave["amplitude"] * (np.sin(turns) + second * np.sin(2.0 * turns + 0.7))
    return error


def _cable(at: FloatArray, stroke: float) -> FloatArray:
    """Pull of a cable that gets taut over the last third of the way, 0 to 1."""
    taut = np.clip((at - at.min()) / stroke - 0.6, 0.0, None) / 0.4
    pull: FloatArray = taut**1.5
    return pull
