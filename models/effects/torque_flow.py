"""What passes along the chain of a servo delta backwards: from its motion to its currents."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from deltactl.models.effects.flow import Flow
from deltactl.models.robot import FloatArray


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
