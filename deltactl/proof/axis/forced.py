"""An axis driven by effort: a mass with bristle friction under a cascaded position controller."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field, replace
from math import copysign, exp

import numpy as np
from scipy.interpolate import CubicSpline

from deltactl.proof.axis.commanded import Sizes
from deltactl.proof.axis.drives import LuGre, delayed
from deltactl.proof.axis.motions import FloatArray, Motion

BRISTLE = 3e-4
"""Motion before sliding, in strokes."""
STIFFEST = 0.4
"""Most that the bristles' own oscillation may turn in one step, in radians."""

STABLE = 0.35
"""Bandwidth times delay of a loop that is tuned with care, in radians."""
RANGE = 1.5
"""How far the demand of a drive may exceed what its amplifier gives, over the latter."""
SLOW = 0.03
"""Share of the fastest speed below which a mass counts as at rest."""


@dataclass(frozen=True)
class Moved:
    """What the controller made of a motion; all (n,) on its grid."""

    position: FloatArray
    speed: FloatArray
    acceleration: FloatArray
    asked: FloatArray
    """Force that the controller asked for: the effort times the gain of the robot file."""


@dataclass(frozen=True)
class ForcedAxis:
    """inertia * acceleration = gain * effort - friction - offset - holding + load.

    Force in N or N m, `gravity` (torque, zero) as the robot file defines it, `weight` a constant
    that the file gives, `load` a recorded pull. `moved` is there once `run` has moved it.
    """

    motion: Motion
    inertia: float
    gravity: tuple[float, float] = (0.0, 0.0)
    weight: float = 0.0
    load: FloatArray = field(default_factory=lambda: np.zeros(1))
    neighbour: FloatArray = field(default_factory=lambda: np.zeros(1))
    bandwidth: float = 1.0
    """Bandwidth of the speed loop, rad/s."""
    moved: Moved | None = None

    def run(self, sizes: Sizes) -> ForcedAxis:
        """The same axis after it was moved with these faults."""
        # What acts from outside acts where the axis is, which the first pass tells.
        first = self._move(sizes, self.motion.position)
        return replace(self, moved=self._move(sizes, first.position))

    def clean(self, sizes: Sizes, rows_s: FloatArray, ideal: bool = False) -> FloatArray:
        """Force (n,) that effort times the file's gain would state for the motion that was."""
        moved = self._done()
        outside = self._outside(moved.position, sizes)
        inertia = sizes.get("inertia", {}).get("inertia", self.inertia)
        force = inertia * moved.acceleration + outside + self._rub(sizes, moved, ideal)
        given = force / self._gain(sizes)
        lag = sizes.get("following_lag", {})
        step_s, t_s = self.motion.step_s, self.motion.t_s
        given = given + lag.get("time", 0.0) * np.gradient(given, step_s)
        given = np.interp(t_s + lag.get("dead_time", 0.0), t_s, given)
        if "effort_limit" in sizes:
            # What the limit keeps back is asked for and not given.
            limit = sizes["effort_limit"]["limit"]
            given = given + moved.asked - np.clip(moved.asked, -limit, limit)
        return np.interp(rows_s, t_s, given)

    def recorded(self, rows_s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Position, speed and asked force (n,) at the rows' true times."""
        moved, t_s = self._done(), self.motion.t_s
        # A straight line between two steps is off by as much as some percent of the acceleration.
        at: FloatArray = CubicSpline(t_s, moved.position)(rows_s)
        speed, asked = (np.interp(rows_s, t_s, signal) for signal in (moved.speed, moved.asked))
        return at, speed, asked

    def informative(self, rows_s: FloatArray) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
        """Rows in motion: at rest friction holds with whatever force there is."""
        speed = np.abs(np.interp(rows_s, self.motion.t_s, self._done().speed))
        moving: np.ndarray[tuple[int], np.dtype[np.bool_]] = speed > SLOW * speed.max()
        return moving

    def _done(self) -> Moved:
        if self.moved is None:
            raise ValueError("the axis was not moved yet; take what `run` returns")
        return self.moved

    def _gain(self, sizes: Sizes) -> FloatArray | float:
        """True force over stated force."""
        scale = sizes.get("effort_gain", {}).get("scale", 1.0)
        if "gain_drifts" in sizes:
            warm = sizes["gain_drifts"]
            faded = np.exp(-self.motion.t_s / warm["time"])
            gain: FloatArray = scale * (1.0 + warm["share"] * (faded - 1.0))
            return gain
        return scale

    def _outside(self, at: FloatArray, sizes: Sizes) -> FloatArray:
        """Force that has to be overcome beside inertia and friction."""
        torque, zero = self.gravity
        held = self.weight + torque * np.sin(at - zero) - self.load
        held = held + sizes.get("effort_offset", {}).get("offset", 0.0)
        if "coupling" in sizes:
            held = held + sizes["coupling"]["size"] * self.neighbour
        if "weight_not_given" in sizes:
            drawn = sizes["weight_not_given"]
            held = held + drawn["size"] * np.sin(at - drawn["zero"])
        if "cogging" in sizes:
            drawn = sizes["cogging"]
            held = held + drawn["size"] * np.sin(2.0 * np.pi * at / drawn["period"])
        if "elastic_cable" in sizes:
            taut = np.clip((at - self.motion.position.min()) / self.motion.stroke - 0.5, 0.0, None)
            held = held + sizes["elastic_cable"]["size"] * (2.0 * taut) ** 1.5
        outside: FloatArray = held
        return outside

    def _friction(self, sizes: Sizes) -> LuGre | None:
        """None where nothing rubs."""
        coulomb = sizes.get("joint_friction", {}).get("torque", 0.0)
        falls = sizes.get("stribeck_friction", {"torque": 0.0, "speed": 1.0})
        viscous = sizes.get("viscous_friction", {}).get("coefficient", 0.0)
        grows = sizes.get("friction_by_position", {}).get("torque", 0.0)
        most = coulomb + falls["torque"] + grows
        if most == 0.0 and viscous == 0.0:
            return None
        stiffest = self.inertia * (STIFFEST / self.motion.step_s) ** 2
        bristle = min(max(most, 1e-12) / (BRISTLE * self.motion.stroke), stiffest)
        damper = np.sqrt(bristle * self.inertia)
        return LuGre(coulomb + grows, falls["torque"], falls["speed"], viscous, bristle, damper)

    def _of_place(self, at: FloatArray, sizes: Sizes) -> FloatArray | float:
        if "friction_by_position" not in sizes:
            return 1.0
        share = (at - self.motion.position.min()) / self.motion.stroke
        grows: FloatArray = np.clip(share, 0.02, 1.5) ** 2
        return grows

    def _rub(self, sizes: Sizes, moved: Moved, ideal: bool) -> FloatArray:
        friction = self._friction(sizes)
        if friction is None:
            return np.zeros_like(moved.speed)
        of_place = self._of_place(moved.position, sizes)
        if not ideal:
            return friction.along(moved.speed, self.motion.step_s, of_place)
        # Sliding or not: within a thousandth of the usual speed it tells nothing of direction.
        slow = 1e-3 * self.motion.stroke / self.motion.stroke_s
        way = np.tanh(moved.speed / slow)
        dry: FloatArray = friction.most(moved.speed) * of_place * way
        return dry + friction.viscous * moved.speed

    def _move(self, sizes: Sizes, places: FloatArray) -> Moved:
        """The closed loop, step by step; the motor's lag and limits are within it.

        places: where the axis is, (n,), as far as forces from outside depend on it.
        """
        motion, step_s = self.motion, self.motion.step_s
        rubs = self._friction(sizes)
        friction = rubs or LuGre(0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
        lag = sizes.get("following_lag", {})
        dead = round(lag.get("dead_time", 0.0) / step_s)
        keep = np.exp(-step_s / lag["time"]) if lag.get("time", 0.0) > 0.0 else 0.0
        limit = sizes.get("effort_limit", {}).get("limit", np.inf)
        mass = sizes.get("inertia", {}).get("inertia", self.inertia)
        target = motion.position
        ahead = np.gradient(target, step_s)
        push = self.inertia * np.gradient(ahead, step_s)
        outside = (self._outside(places, sizes) * np.ones_like(target)).tolist()
        of_place = (self._of_place(places, sizes) * np.ones_like(target)).tolist()
        gain = (self._gain(sizes) * np.ones_like(target)).tolist()
        late_s = step_s * dead + lag.get("time", 0.0)
        # Whoever tunes the loop tunes it to the delay that it has.
        inner = min(self.bandwidth, STABLE / late_s) if late_s > 0.0 else self.bandwidth
        outer = inner / 4.0
        fastest = 2.0 * float(np.abs(ahead).max())
        at, speed, bent = float(target[0]), 0.0, 0.0
        # At rest from the beginning: the controller holds what has to be held.
        given = integral = float(outside[0] / gain[0])
        waiting = deque([given] * dead)
        out: list[tuple[float, float, float, float]] = []
        coulomb, breakaway = friction.coulomb, friction.breakaway
        falls, viscous = friction.stribeck_speed, friction.viscous
        bristle, damper = friction.bristle, friction.damper
        proportional, builds = self.inertia * inner, self.inertia * inner**2 / 8.0
        rub = new = rise = 0.0
        for place, rate, feed, hold, factor, real in zip(
            target.tolist(), ahead.tolist(), push.tolist(), outside, of_place, gain, strict=True
        ):
            back = outer * (place - at)
            off = rate + (back if -fastest < back < fastest else copysign(fastest, back)) - speed
            asked = feed + proportional * off + integral
            asked = asked if abs(asked) < RANGE * limit else copysign(RANGE * limit, asked)
            if dead:
                waiting.append(asked)
                given = keep * given + (1.0 - keep) * waiting.popleft()
            else:
                given = keep * given + (1.0 - keep) * asked
            limited = given if -limit < given < limit else copysign(limit, given)
            if limited == given:
                integral += builds * off * step_s
            # `speed` is that of half a step before, so that places are exact to second order.
            now = speed + 0.5 * rise * step_s
            if rubs:
                most = coulomb
                if breakaway:
                    most += breakaway * exp(-min((now / falls) ** 2, 50.0))
                most, fast = max(most * factor, 1e-12), max(abs(now), 1e-12)
                new = (bent + now * step_s) / (1.0 + bristle * fast * step_s / most)
                damped = min(damper, most / fast)
                rub = bristle * new + damped * (new - bent) / step_s + viscous * now
            rise = (real * limited - hold - rub) / mass
            out.append((at, now, rise, asked))
            bent = new
            speed += rise * step_s
            at += speed * step_s
        columns = np.array(out).T
        return Moved(*columns)


def neighbour(motion: Motion, rng: np.random.Generator) -> FloatArray:
    """Another axis of the machine that makes moves of its own, -1 to 1."""
    count = int(motion.t_s[-1] / motion.stroke_s) + 4
    knots = np.repeat(rng.uniform(-1.0, 1.0, count), 2)
    takes = np.tile([1.3, 0.4], count)[: len(knots)] * motion.stroke_s
    when = np.cumsum(takes) - rng.uniform(0.0, 2.0) * motion.stroke_s
    pulled: FloatArray = np.interp(motion.t_s, when, knots)
    return delayed(pulled, motion.t_s, 0.0)
