"""Independent simulators of single axes: their own code, step by step, nothing of the chain."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from deltactl.recording.tables.flat import FlatRecording, from_columns

FloatArray = NDArray[np.float64]


def correlated(rng: np.random.Generator, count: int, sigma: float, rho: float) -> FloatArray:
    """Noise with standard deviation sigma whose neighbours have the correlation rho."""
    first, *white = rng.standard_normal(count).tolist()
    noise, new = [first], math.sqrt(1.0 - rho**2)
    for each in white:
        noise.append(rho * noise[-1] + new * each)
    return sigma * np.array(noise)


def wander(rng: np.random.Generator, t_s: FloatArray, size: float, slow_s: float) -> FloatArray:
    """A smooth motion with rests: random targets, cosine moves, some of them held."""
    targets = rng.uniform(-size, size, int(t_s[-1] / slow_s) + 3)
    number = (t_s / slow_s).astype(int)
    share = np.clip((t_s / slow_s - number) * 1.3, 0.0, 1.0)
    bend = 0.5 - 0.5 * np.cos(np.pi * share)
    motion: FloatArray = targets[number] + (targets[number + 1] - targets[number]) * bend
    return motion


@dataclass(frozen=True)
class ForcedRig:
    """A mass with friction that a PD loop drives: 2 kHz inside, recorded every `every` steps."""

    mass: float = 2.0
    coulomb: float = 0.0
    viscous: float = 0.0
    stribeck: float = 0.0
    stribeck_speed: float = 0.02
    offset: float = 0.0
    gain: float = 1.0
    gravity: float = 0.0
    zero: float = 0.0
    noise: float = 1e-5
    rho: float = 0.0
    every: int = 10

    def record(self, seed: int, span_s: float = 20.0, size: float = 0.3) -> FlatRecording:
        """t, position and effort; true force = gain * effort - offset."""
        rng = np.random.default_rng(seed)
        step_s = 0.0005
        count = int(span_s / step_s)
        asked = wander(rng, np.arange(count) * step_s, size, 1.5).tolist()
        omega = 25.0
        x, v, u = asked[0], 0.0, 0.0
        kept = []
        for k in range(count):
            if k % self.every == 0:
                speed = (asked[min(k + 1, count - 1)] - asked[k]) / step_s
                u = self.mass * (omega**2 * (asked[k] - x) + 1.6 * omega * (speed - v))
                kept.append((k * step_s, x, u))
            push = self.gain * u - self.offset - self.gravity * math.sin(x - self.zero)
            push -= self.viscous * v
            rub = self.coulomb + self.stribeck * math.exp(-((v / self.stribeck_speed) ** 2))
            free = v + push / self.mass * step_s
            brake = rub / self.mass * step_s
            v = math.copysign(max(abs(free) - brake, 0.0), free)
            x += v * step_s
        t_s, position, effort = (np.array(column) for column in zip(*kept, strict=True))
        position = position + correlated(rng, len(position), self.noise, self.rho)
        return from_columns({"t": t_s, "position": position, "effort": effort}, "rig")


@dataclass(frozen=True)
class FollowingRig:
    """An axis that follows its command with a lag, play, and errors of gear and encoder."""

    lag_s: float = 0.0
    dead_s: float = 0.0
    play: float = 0.0
    offset: float = 0.0
    scale: float = 1.0
    wave: float = 0.0
    period: float = 0.1
    lost: float = 0.0
    lost_at_s: float = 15.0
    bend: float = 0.0
    noise: float = 2e-4
    rho: float = 0.3
    encoder_step: float = 0.0
    rate_hz: float = 50.0

    def record(
        self, seed: int, span_s: float = 30.0, size: float = 0.4, names: str = "command position"
    ) -> FlatRecording:
        """t, the command and what the encoder read."""
        rng = np.random.default_rng(seed)
        fine = 10
        t_fine = np.arange(int(span_s * self.rate_hz) * fine) / (self.rate_hz * fine)
        command = wander(rng, t_fine, size, 2.0)
        driven = np.interp(t_fine - self.dead_s, t_fine, command)
        x, axis = float(driven[0]), float(driven[0]) + 0.3 * self.play
        followed = []
        part = 1.0 - np.exp(-t_fine[1] / self.lag_s) if self.lag_s else 1.0
        halfway = 0.5 * (driven + np.concatenate([driven[:1], driven[:-1]]))
        targets = (halfway if self.lag_s else driven).tolist()
        for now_s, target in zip(t_fine.tolist(), targets, strict=True):
            x += (target - x) * part
            motor = self.scale * x - (self.lost if now_s >= self.lost_at_s else 0.0)
            motor += self.wave * math.sin(2.0 * math.pi * motor / self.period)
            axis = min(max(axis, motor - 0.5 * self.play), motor + 0.5 * self.play)
            followed.append(axis + self.offset + self.bend * axis**3)
        t_s, command, seen = t_fine[::fine], command[::fine], np.array(followed[::fine])
        seen = seen + correlated(rng, len(seen), self.noise, self.rho)
        if self.encoder_step:
            seen = np.round(seen / self.encoder_step) * self.encoder_step
        first, second = names.split()
        return from_columns({"t": t_s, first: command, second: seen}, "rig")


@dataclass(frozen=True)
class RangingRig:
    """A ranging sensor looking at a target that is moved to and fro."""

    offset: float = 0.0
    scale: float = 1.0
    curvature: float = 0.0
    drift: float = 0.0
    late_s: float = 0.0
    noise: float = 0.002
    rho: float = 0.4

    def record(self, seed: int, span_s: float = 30.0) -> FlatRecording:
        """t, distance and range at 20 Hz, in whole millimetres."""
        rng = np.random.default_rng(seed)
        t_s = np.arange(int(span_s * 20.0)) / 20.0
        distance = 0.4 + wander(rng, t_s, 0.25, 3.0)
        seen = np.interp(t_s - self.late_s, t_s, distance)
        read = self.offset + self.scale * seen + self.curvature * seen**2
        read = read + self.drift * (1.0 - np.exp(-t_s / 15.0))
        read = read + correlated(rng, len(t_s), self.noise, self.rho)
        return from_columns({"t": t_s, "distance": distance, "range": np.round(read, 3)}, "rig")
