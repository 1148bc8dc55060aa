"""Between where the platform is and where the sensors of a calibrated robot see it."""

from __future__ import annotations

import numpy as np

from models.chain.active import at, of_entries
from models.effects.flow import Flow, Load
from models.effects.port import Port
from models.robot import DeltaRobot, FloatArray

ROUNDS = 20
CLOSE_M = 1e-9


def seen_m(robot: DeltaRobot, position_m: FloatArray) -> FloatArray:
    """What the sensors make of a platform at rest at positions (n, 3) [m], same shape.

    With the robot's known effects, read with the robot file's own offsets and axes.
    """
    assert robot.sensors is not None
    axes, offsets_m = robot.sensors.axes, robot.sensors.offsets_m
    nothing = np.zeros_like(position_m)
    still = np.zeros(len(position_m))
    flow = Flow(still, still == 0.0, 0.0, nothing, lambda: Load(nothing, nothing))
    flow.position_m = position_m
    flow.sensor_axes, flow.sensor_offsets_m = axes, offsets_m
    known = of_entries(robot.effects)
    for active in at(known, Port.PLATFORM):
        active.act(flow)
    flow.ranges_m = offsets_m + flow.position_m @ axes.T
    for active in at(known, Port.SENSOR):
        active.act(flow)
    seen: FloatArray = np.linalg.solve(axes, (flow.ranges_m - offsets_m).T).T
    return seen


def true_m(robot: DeltaRobot, measured_m: FloatArray) -> FloatArray:
    """Where the platform is when it is seen at (n, 3) [m]: `seen_m` turned round, same shape."""
    position_m = np.array(measured_m, dtype=np.float64)
    for _ in range(ROUNDS):
        missing_m = measured_m - seen_m(robot, position_m)
        position_m = position_m + missing_m
        if np.abs(missing_m).max(initial=0.0) < CLOSE_M:
            break
    return position_m
