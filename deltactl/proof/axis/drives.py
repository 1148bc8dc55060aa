"""What is between a command and a motor: loops, limits, dead time, ringing; and friction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import cont2discrete, lfilter

from deltactl.proof.axis.motions import FloatArray


@dataclass(frozen=True)
class LuGre:
    """Friction of a sliding mass, SI units of its motion.

    coulomb: force of steady sliding. breakaway: how much more it is near standstill; it falls off
    with exp(-(v / stribeck_speed)^2). viscous: force per speed. bristle: stiffness before sliding.
    damper: of the bristles near standstill. In sliding it falls with the speed, or friction would
    drive the mass (Astrom and Canudas de Wit 2008, 'Revisiting the LuGre friction model', IEEE
    Control Systems Magazine 28(6), condition of dissipation), and come before its speed.
    """

    coulomb: float
    breakaway: float
    stribeck_speed: float
    viscous: float
    bristle: float
    damper: float

    def most(self, speed: FloatArray) -> FloatArray:
        """Dry force of steady sliding at a speed."""
        falls: FloatArray = np.exp(-((speed / self.stribeck_speed) ** 2))
        most: FloatArray = self.coulomb + self.breakaway * falls
        return most

    def along(self, speed: FloatArray, step_s: float, of_place: FloatArray | float) -> FloatArray:
        """Force (n,) that a known motion meets; the bristles bend by an implicit step.

        of_place: factor of the dry part, (n,) or one.
        """
        most = np.maximum(self.most(speed) * of_place, 1e-12)
        grow = 1.0 / (1.0 + self.bristle * np.abs(speed) * step_s / most)
        bent = linear_recursion(grow, grow * speed * step_s)
        rate = np.diff(bent, prepend=0.0) / step_s
        damper = np.minimum(self.damper, most / np.maximum(np.abs(speed), 1e-12))
        force: FloatArray = self.bristle * bent + damper * rate + self.viscous * speed
        return force


def linear_recursion(factor: FloatArray, forcing: FloatArray) -> FloatArray:
    """z[k] = factor[k] z[k-1] + forcing[k] from z = 0."""
    z, out = 0.0, []
    for a, b in zip(factor.tolist(), forcing.tolist(), strict=True):
        z = a * z + b
        out.append(z)
    return np.array(out)


def play(driven: FloatArray, width: FloatArray | float, start: float) -> FloatArray:
    """The play operator: the output rests until the drive has crossed `width`.

    start: where in the play it begins, -1 to 1.
    """
    half = 0.5 * width * np.ones_like(driven)
    low, high = (driven - half).tolist(), (driven + half).tolist()
    at, out = float(driven[0] + start * half[0]), []
    for least, most in zip(low, high, strict=True):
        at = least if at < least else min(at, most)
        out.append(at)
    return np.array(out)


def wound_up(
    driven: FloatArray, width: FloatArray | float, slip: float, start: float
) -> FloatArray:
    """An axis whose bearing (Dahl) winds up the shaft that drives it.

    A bearing of force F winds a shaft of stiffness k up by F / k either way, so that the axis is
    behind by half of width = 2 F / k. slip: motion of the axis over which the friction builds up;
    with no slip this is the play operator.
    """
    half = (0.5 * width * np.ones_like(driven)).tolist()
    steps = np.diff(driven, prepend=driven[0]).tolist()
    places = driven.tolist()
    z, out = -start, []
    for place, step, h in zip(places, steps, half, strict=True):
        way = 1.0 if step > 0.0 else -1.0
        left = max(1.0 - way * z, 0.0)
        z += left / slip * step / (1.0 + h * left / slip)
        z = 1.0 if z > 1.0 else max(z, -1.0)
        out.append(place - h * z)
    return np.array(out)


@dataclass(frozen=True)
class PositionLoop:
    """A proportional position loop over a fast speed loop, with feed-forward and its limits.

    The error e of speed = feed_forward u' + e / time obeys e' = (1 - feed_forward) u' - e / time:
    without feed-forward the axis is a first-order lag of `time`, with all of it there is none, and
    with more than all it runs ahead of its command while this changes.
    """

    time_s: float
    feed_forward: float = 0.0
    back_time_s: float | None = None
    """Time in negative motion where it differs."""
    speed_limit: float = np.inf
    acceleration_limit: float = np.inf

    def follow(self, command: FloatArray, step_s: float) -> FloatArray:
        """Where the motor is, from rest at the first command."""
        unlimited = np.isinf(self.speed_limit) and np.isinf(self.acceleration_limit)
        if unlimited and self.back_time_s is None:
            return self._linear(command, step_s)
        return self._limited(command, step_s)

    def _linear(self, command: FloatArray, step_s: float) -> FloatArray:
        """Exact between samples where the command is a straight line."""
        keep = np.exp(-step_s / self.time_s)
        slope = np.diff(command, prepend=command[0])
        share = (1.0 - self.feed_forward) * self.time_s / step_s * (1.0 - keep)
        behind = lfilter([1.0], [1.0, -keep], share * slope)
        followed: FloatArray = command - behind
        return followed

    def _limited(self, command: FloatArray, step_s: float) -> FloatArray:
        speeds = (np.diff(command, prepend=command[0]) / step_s * self.feed_forward).tolist()
        back = self.time_s if self.back_time_s is None else self.back_time_s
        forth, back = -np.expm1(-step_s / self.time_s), -np.expm1(-step_s / back)
        fastest, most = self.speed_limit, self.acceleration_limit * step_s
        at, speed, out = float(command[0]), 0.0, []
        for target, ahead in zip(command.tolist(), speeds, strict=True):
            error = target - at - ahead * step_s
            asked = ahead + error * (forth if error > 0.0 else back) / step_s
            change = asked - speed
            asked = speed + min(max(change, -most), most)
            speed = min(max(asked, -fastest), fastest)
            at += speed * step_s
            out.append(at)
        return np.array(out)


def delayed(signal: FloatArray, t_s: FloatArray, by_s: float) -> FloatArray:
    """The same signal later; before its beginning it was at rest."""
    return signal if by_s == 0.0 else np.interp(t_s - by_s, t_s, signal)


def ringing(driven: FloatArray, step_s: float, frequency_hz: float, damping: float) -> FloatArray:
    """A mass on a damped spring that is moved at its foot, both spring and damper.

    x'' + 2 d w (x' - u') + w^2 (x - u) = 0: `frequency` is the undamped one, w / 2 pi.
    """
    omega = 2.0 * np.pi * frequency_hz
    top, bottom = [2.0 * damping * omega, omega**2], [1.0, 2.0 * damping * omega, omega**2]
    b, a, _ = cont2discrete((top, bottom), step_s, method="foh")
    first = driven[0]
    rung: FloatArray = first + lfilter(np.ravel(b), a, driven - first)
    return rung


@dataclass(frozen=True)
class DeadBand:
    """Two masses with a dead band between them (Nordin and Gutman 2002, Automatica 38, 1633).

    The drive's side is held stiffly; the load is pushed by a spring and damper only outside the
    band, and rubs in its bearing. frequency_hz: of the load on the spring, sliding friction as an
    acceleration.
    """

    width: float
    frequency_hz: float
    damping: float
    rub: float

    def follow(self, driven: FloatArray, step_s: float, start: float) -> FloatArray:
        """Where the load is, by semi-implicit steps; the friction's own step is implicit."""
        omega = 2.0 * np.pi * self.frequency_hz
        spring, damper, half = omega**2, 2.0 * self.damping * omega, 0.5 * self.width
        at, speed, out = float(driven[0] + start * half), 0.0, []
        speeds = (np.diff(driven, prepend=driven[0]) / step_s).tolist()
        brake = self.rub * step_s
        for place, moves in zip(driven.tolist(), speeds, strict=True):
            out.append(at)
            gap = place - at
            if gap > half:
                push = max(spring * (gap - half) + damper * (moves - speed), 0.0)
            elif gap < -half:
                push = min(spring * (gap + half) + damper * (moves - speed), 0.0)
            else:
                push = 0.0
            free = speed + push * step_s
            speed = max(free - brake, 0.0) if free > 0.0 else min(free + brake, 0.0)
            at += speed * step_s
        return np.array(out)
