"""What no workshop avoids: everything a little off, everywhere."""

from __future__ import annotations

import numpy as np

from deltactl.proof.recorded import Machine

LENGTH_M = 1e-4
ANGLE_RAD = 4e-4
SENSOR_M = 4e-4
SHARE = 3e-4


def tolerances(machine: Machine, rng: np.random.Generator) -> None:
    """Standard deviations: 0.1 mm in lengths, 0.023 degrees in angles, 0.4 mm in sensors."""
    body, joints, sensors = machine.robot.body, machine.robot.joints, machine.sensors

    def three(size: float) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        return size * np.clip(rng.standard_normal(3), -2.5, 2.5)

    body.upper_arm_m += three(LENGTH_M)
    body.forearm_m += three(LENGTH_M)
    body.base_radius_m += three(LENGTH_M)
    body.azimuth_rad += three(ANGLE_RAD)
    joints.home_rad += three(ANGLE_RAD)
    joints.scale += three(SHARE)
    joints.wave_rad += np.abs(three(ANGLE_RAD))
    joints.play_rad += np.abs(three(ANGLE_RAD))
    joints.friction_nm += np.abs(three(0.5))
    sensors.offset_m += three(SENSOR_M)
    sensors.scale += three(SHARE)
    sensors.turned_rad += three(ANGLE_RAD)
