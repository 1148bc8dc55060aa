"""What one built robot really is, every figure of it; and the step counts that it is sent."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

FloatArray = np.ndarray[Any, np.dtype[np.float64]]
Bend = Callable[[FloatArray, FloatArray], FloatArray]
"""Angles (n, 3) [rad] and times (n,) [s] -> angles (n, 3): an error of the gears of any shape."""

Pull = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]
"""Times (n,) [s], platform positions and velocities (n, 3) [m, m/s] -> forces (n, 3) [N]."""

YIELDS_NM_PER_RAD = 4_000.0
STIFF_NM_PER_RAD = 20_000.0
"""Joints of a robot without compliance: gravity (1 to 2 N m) bends them by 0.08 mrad."""


def three(value: float) -> FloatArray:
    """The same value for all three arms."""
    return np.full(3, value)


@dataclass
class Body:
    """Lengths, directions and masses; one value an arm where it is an array of shape (3,).

    Lengths and masses: Zhao 2023, Tables 1 and 2 (upper arm and forearm are swapped in print).
    """

    base_radius_m: FloatArray = field(default_factory=lambda: three(0.325))
    platform_radius_m: FloatArray = field(default_factory=lambda: three(0.075))
    upper_arm_m: FloatArray = field(default_factory=lambda: three(0.25))
    forearm_m: FloatArray = field(default_factory=lambda: three(0.5))
    azimuth_rad: FloatArray = field(default_factory=lambda: np.radians([0.0, 120.0, 240.0]))
    rod_distance_m: float = 0.06
    """Between the two rods of a forearm."""
    upper_arm_kg: float = 0.205
    forearm_kg: float = 0.153
    platform_kg: float = 0.653
    payload_kg: float = 0.0
    table_height_m: float | None = None
    """Height at which a table stops the middle of the platform."""
    growth: float = 0.0
    growth_time_s: float = 100.0
    """Upper arms lengthen by `growth` (1 - exp(-t / growth_time_s))."""
    ringing_hz: float | None = None
    """The sensors' targets are mounted on the platform by springs of this frequency, if any."""
    ringing_damping: float = 0.1
    pulls: list[Pull] = field(default_factory=list)
    """Forces on the platform that have no name; stiff joints hardly show them."""


@dataclass
class Joints:
    """Drives, gears and bearings."""

    rad_per_step: float = 2.0 * np.pi / 16_000.0
    home_rad: FloatArray = field(default_factory=lambda: three(0.0))
    scale: FloatArray = field(default_factory=lambda: three(1.0))
    lag_s: FloatArray = field(default_factory=lambda: three(0.0))
    dead_time_s: FloatArray = field(default_factory=lambda: three(0.0))
    lost_steps: FloatArray = field(default_factory=lambda: three(0.0))
    lost_at_s: FloatArray = field(default_factory=lambda: three(0.0))
    wave_rad: FloatArray = field(default_factory=lambda: three(0.0))
    wave_phase_rad: FloatArray = field(default_factory=lambda: three(0.0))
    waves_per_turn: float = 10.0
    play_rad: FloatArray = field(default_factory=lambda: three(0.0))
    play_shape: Bend | None = None
    """Where the play depends on the angle: the width [rad] for angles and times."""
    stiffness_nm_per_rad: FloatArray = field(default_factory=lambda: three(STIFF_NM_PER_RAD))
    friction_nm: FloatArray = field(default_factory=lambda: three(0.02))
    drag_nms_per_rad: FloatArray = field(default_factory=lambda: three(0.3))
    hub_kgm2: float = 0.02
    """Inertia of a gear's output stage, hub and arm clamp, which moves with the arm."""
    limit_nm: float = 80.0
    """Beyond this torque the closed-loop drive yields and comes back (no steps are lost)."""
    yields_at_nm: float | None = None
    """Torque beyond which stiff gears give way by `YIELDS_NM_PER_RAD`, where something is pressed
    on; free motion never asks for as much."""
    bends: list[Bend] = field(default_factory=list)
    """Errors that have no name: each adds to the angle the gear asks for."""


@dataclass
class AsBuilt:
    """Body and joints of one robot."""

    body: Body = field(default_factory=Body)
    joints: Joints = field(default_factory=Joints)


IntArray = np.ndarray[Any, np.dtype[np.int64]]


@dataclass(frozen=True)
class StepTrain:
    """counts[k] (3,) is the count from `k * t_pwm_s` on; shape (n, 3)."""

    t_pwm_s: float
    counts: IntArray

    @property
    def seconds(self) -> float:
        """How long the motion lasts."""
        return len(self.counts) * self.t_pwm_s

    def at(self, t_s: FloatArray) -> IntArray:
        """Commanded counts at given times, shape (n, 3)."""
        tick = np.floor(t_s / self.t_pwm_s + 1e-9).astype(int)
        counts: IntArray = self.counts[np.clip(tick, 0, len(self.counts) - 1)]
        return counts

    def smooth(self, t_s: FloatArray) -> FloatArray:
        """Counts as a rotor turns: the staircase averaged over one step period, no lag; (n, 3)."""
        ticks_s = np.arange(len(self.counts)) * self.t_pwm_s
        before = np.vstack([self.counts[:1], self.counts[:-1]])
        middle = 0.5 * (before + self.counts)
        return np.stack([np.interp(t_s, ticks_s, middle[:, m]) for m in range(3)], axis=1)


def together(start: IntArray, targets: IntArray, dwell_s: FloatArray, t_pwm_s: float) -> StepTrain:
    """Visit the targets (n, 3) one after another, waiting `dwell_s` (n,) at each."""
    pieces = [start[None, :]]
    here = start
    for target, dwell in zip(targets, dwell_s, strict=True):
        left = target - here
        ticks = np.arange(1, int(np.abs(left).max()) + 1)[:, None]
        pieces.append(here + np.sign(left) * np.minimum(ticks, np.abs(left)))
        pieces.append(np.repeat(target[None, :], round(dwell / t_pwm_s), axis=0))
        here = target
    return StepTrain(t_pwm_s, np.concatenate(pieces))


def cut(train: StepTrain, seconds: float) -> StepTrain:
    """The first seconds of a motion."""
    return StepTrain(train.t_pwm_s, train.counts[: max(2, round(seconds / train.t_pwm_s))])
