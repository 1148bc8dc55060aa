"""What passes along the chain of an axis that is driven by effort: force, then motion."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from deltactl.models.effects.flow import Flow
from deltactl.models.robot import FloatArray

BoolArray = np.ndarray[Any, np.dtype[np.bool_]]


@dataclass
class EffortFlow(Flow):
    """`angles_rad`, shape (n, 1), carries the force (torque) that acts on the moving mass.

    Friction is taken at the velocity that was measured (see models/chain/effort_axis.py).
    """

    position: FloatArray = field(default_factory=lambda: np.empty((0, 1)))
    """Measured position, shape (n, 1)."""
    velocity: FloatArray = field(default_factory=lambda: np.empty((0, 1)))
    """Its smoothed derivative, shape (n, 1)."""
    direction: FloatArray = field(default_factory=lambda: np.empty((0, 1)))
    """Which way it goes, -1 to 1, in between where the velocity hardly tells; shape (n, 1)."""
    at_rest: BoolArray = field(default_factory=lambda: np.empty((0, 1), dtype=bool))
    """Where the velocity cannot be told from zero: friction holds against the force there."""
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
