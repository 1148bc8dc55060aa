"""What passes along the chain: the samples of one block, changed stage by stage."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from deltactl.models.robot import FloatArray
from deltactl.models.signals import delayed, lagged, late, slopes_of

BoolArray = np.ndarray[Any, np.dtype[np.bool_]]


@dataclass
class Load:
    """Gravity at the joints along the commanded motion, from the nominal linkage and masses."""

    torque_nm: FloatArray
    """Shape (n, joints); 0 where the masses are not known."""
    per_kg_nm: FloatArray
    """Torque of one kilogram more at the platform, shape (n, joints)."""


@dataclass
class Flow:
    """Samples of one block; arrays of shape (n,), (n, joints) or (n, 3).

    angles_rad starts as the commanded angles and ends as the true ones.
    """

    t_s: FloatArray
    fresh: BoolArray
    """True where a new stretch starts: filters and play start afresh there."""
    start_s: float
    """Time at which the recording (not the block) began: warming up counts from here."""
    angles_rad: FloatArray
    load_of: Callable[[], Load]
    rad_per_step: float = 0.0
    smooth: bool = False
    """A whole motion, smooth between its samples (`between_rows`); in blocks it is straight."""
    late_s: float = 0.0
    """Time constant of the drive of a whole motion: what pulls at it shows as late in a spring."""
    previous_s: float | None = None
    """Time of the last sample of the block before, if this one goes on from it."""
    linkage: dict[str, FloatArray] = field(default_factory=dict)
    """Fields of Linkage that an effect changed: shape (3,) or (n, 3)."""
    position_m: FloatArray = field(default_factory=lambda: np.empty((0, 3)))
    ranges_m: FloatArray = field(default_factory=lambda: np.empty((0, 3)))
    measured_rad: FloatArray = field(default_factory=lambda: np.empty((0, 3)))
    sensor_axes: FloatArray = field(default_factory=lambda: np.eye(3))
    sensor_offsets_m: FloatArray = field(default_factory=lambda: np.zeros(3))

    @property
    def load(self) -> Load:
        """Gravity at the joints; many chains never ask for it."""
        return self.load_of()

    @cached_property
    def step_s(self) -> FloatArray:
        """Time since the sample before, shape (n,); 0 at a fresh start."""
        before = self.t_s[0] if self.previous_s is None else self.previous_s
        step = np.diff(self.t_s, prepend=before)
        step[self.fresh] = 0.0
        return step

    def behind(
        self, part: FloatArray, dead_s: float, time_s: float, memory: dict[str, Any]
    ) -> FloatArray:
        """Each column of a motion (n, m) behind a dead time and a first-order lag.

        memory: what goes on from block to block; a whole motion leaves it as it is.
        """
        if self.smooth:
            return np.stack([self._late(x, dead_s, time_s) for x in part.T], axis=1)
        start_s = self.stretch_start_s
        if dead_s != 0.0:
            part = delayed(part, self.t_s, start_s, dead_s, memory.setdefault("delay", {}))
        return lagged(part, self.step_s, time_s, memory.setdefault("lag", {}))

    def _late(self, x: FloatArray, dead_s: float, time_s: float) -> FloatArray:
        slopes = slopes_of(x, self.t_s, self.step_s)
        return late(x, slopes, self.t_s, self.stretch_start_s, dead_s, time_s)

    @cached_property
    def since_s(self) -> FloatArray:
        """Time since the recording began, shape (n,)."""
        return self.t_s - self.start_s

    @cached_property
    def stretch_start_s(self) -> FloatArray:
        """Time at which each sample's stretch began within this block, shape (n,)."""
        marks = self.fresh.copy()
        marks[0] = True
        starts = np.flatnonzero(marks)
        start: FloatArray = self.t_s[starts][np.cumsum(marks) - 1]
        return start


@dataclass
class EffortFlow(Flow):
    """`angles_rad`, shape (n, 1), carries the force (torque) that acts on the moving mass.

    Friction is taken at the velocity that was measured (see models/chain/axis.py).
    """

    position: FloatArray = field(default_factory=lambda: np.empty((0, 1)))
    """Measured position, shape (n, 1)."""
    velocity: FloatArray = field(default_factory=lambda: np.empty((0, 1)))
    """Its smoothed derivative, shape (n, 1)."""
    direction: FloatArray = field(default_factory=lambda: np.empty((0, 1)))
    """Which way it goes, -1 to 1, in between where the velocity hardly tells; shape (n, 1)."""
    at_rest: BoolArray = field(default_factory=lambda: np.empty((0, 1), dtype=bool))
    """Where the velocity is not distinguishable from zero: friction holds against the force."""
    inertia: float = 1.0


def effort_flow(flow: Flow) -> EffortFlow:
    """The flow of an effort-driven axis. Raises TypeError on that of another chain."""
    if not isinstance(flow, EffortFlow):
        raise TypeError("this effect acts on an axis that is driven by effort")
    return flow


def rub(flow: EffortFlow, moving: FloatArray, most: FloatArray | float) -> None:
    """Take friction off the force: `moving` (n, 1) in motion; at rest what holds, up to `most`."""
    held = np.clip(flow.angles_rad, -most, most)
    flow.angles_rad -= np.where(flow.at_rest, held, moving)


@dataclass
class TorqueFlow(Flow):
    """`angles_rad`, shape (n, 3), carries the torque [N m] that the motion asks of the motors.

    Everything is at the arms' shafts. The motion itself is given: it was measured.
    """

    turned_rad: FloatArray = field(default_factory=lambda: np.empty((0, 3)))
    """Arm angles, (n, 3)."""
    speed_radps: FloatArray = field(default_factory=lambda: np.empty((0, 3)))
    direction: FloatArray = field(default_factory=lambda: np.empty((0, 3)))
    """Sign of the speed."""
    acceleration_radps2: FloatArray = field(default_factory=lambda: np.empty((0, 3)))
    per_kg_nm: FloatArray = field(default_factory=lambda: np.empty((0, 3)))
    """Torque that one kilogram more at the platform asks for: weight and inertia."""
    rotor_kgm2: float = 0.0
    """Rotor's inertia at the arm, by the robot file."""


def torque_flow(flow: Flow) -> TorqueFlow:
    """The flow of a servo delta. Raises TypeError on that of another chain."""
    if not isinstance(flow, TorqueFlow):
        raise TypeError("this effect acts on the torques of a servo delta")
    return flow
