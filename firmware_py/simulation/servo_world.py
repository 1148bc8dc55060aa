"""The simulated robot with servo drives: a plant moved by currents, seen by the same sensors.

The plant gives the true arm angles; from there to the sensors the chain of models/chain goes on
as for a stepper, with the hidden `as_built.effects`. Brakes or not, whoever switches the
drives off puts the arms against their stops, as a careful operator would.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

import numpy as np

from deltactl.drivers.current_drives import Three
from deltactl.drivers.fakes.current_drives import FakeCurrentDrives
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.firmware_py.servo.as_built import AsBuiltServo
from deltactl.firmware_py.simulation.world import MEMORY_S, SimulatedRobot
from deltactl.models.dynamics import DeltaPlant, PlantSettings
from deltactl.models.robot import FloatArray, Masses
from deltactl.models.servo_drive import ServoDrive

BLOCKS_KEPT = round(MEMORY_S / 1e-3)


def plant_of(robot: RobotFile, drive: ServoDrive, masses: Masses) -> DeltaPlant:
    """The plant of a robot as it was built, its arms at the home angles."""
    built = robot.as_built.servo or AsBuiltServo()
    heavier = {name: value * built.mass_scale for name, value in masses.model_dump().items()}
    settings = PlantSettings(
        geometry=robot.geometry,
        masses=Masses(**heavier),
        period_s=drive.period_s,
        gear_ratio=drive.gear_ratio,
        rotor_inertia_kgm2=drive.rotor_inertia_kgm2 * built.rotor_inertia_scale,
        torque_constants_nmpa=_times(drive.torque_constant_nmpa, built.torque_constant_scale),
        coulomb_nm=_times(drive.coulomb_nm, built.coulomb_scale),
        viscous_nmsprad=_times(drive.viscous_nmsprad, built.viscous_scale),
        payload_kg=built.payload_kg,
        stops_rad=_stops_rad(robot),
    )
    return DeltaPlant(settings, rest_rad(robot))


def rest_rad(robot: RobotFile) -> Three:
    """True angles at which the arms rest: at home, or hanging below their home switches."""
    offsets = np.deg2rad(robot.geometry.home_offset_deg)
    angles = np.deg2rad(robot.homing.angle_deg) + offsets + SimulatedRobot.droop_rad(robot)
    first, second, third = angles.tolist()
    return first, second, third


class ServoWorld(SimulatedRobot):
    """See SimulatedRobot; the loop reports how far it has run."""

    def __init__(self, robot: RobotFile, drives: FakeCurrentDrives, now_ns: Callable[[], int]):
        self._drives = drives
        self._passed: deque[tuple[int, Three]] = deque(
            [(now_ns(), drives.plant.angles_rad())], maxlen=BLOCKS_KEPT
        )
        self._offset_rad = np.deg2rad(robot.geometry.home_offset_deg).tolist()
        self._per_rad = 1.0 / robot.drive.rad_per_step
        super().__init__(robot, self._angles_in_counts, now_ns)

    def passed(self, t_ns: int) -> None:
        """The loop has run up to this time."""
        self._passed.append((t_ns, self._drives.plant.angles_rad()))

    def put_to_stops(self, t_ns: int) -> None:
        """See SimulatedRobot."""
        with self._lock:
            self._advance(t_ns)
            self._drives.put(rest_rad(self._robot))
            self._put(np.zeros(3))

    def _zero_at(self, counts: FloatArray) -> FloatArray:
        """The plant itself knows where the arms are."""
        return np.zeros(3)

    def _angles_in_counts(self, t_ns: int) -> Three:
        """Commanded resting angle of the arms, at times that only increase, in set-points."""
        passed = self._passed
        while len(passed) > 1 and passed[1][0] <= t_ns:
            passed.popleft()
        (early_ns, angles), (late_ns, then) = passed[0], passed[min(1, len(passed) - 1)]
        part = 0.0 if late_ns == early_ns else max(0.0, (t_ns - early_ns) / (late_ns - early_ns))
        (a1, a2, a3), (b1, b2, b3), (o1, o2, o3) = angles, then, self._offset_rad
        per_rad, left = self._per_rad, 1.0 - part
        return (
            (left * a1 + part * b1 - o1) * per_rad,
            (left * a2 + part * b2 - o2) * per_rad,
            (left * a3 + part * b3 - o3) * per_rad,
        )


def _times(value: float, scales: Three) -> Three:
    first, second, third = scales
    return value * first, value * second, value * third


def _stops_rad(robot: RobotFile) -> tuple[float, float]:
    """Stops a little beyond the arm limits, so that a limit itself can be reached."""
    low, high = np.deg2rad(robot.limits.arm_deg) + np.deg2rad([-BEYOND_DEG, BEYOND_DEG])
    return float(low), float(high)


BEYOND_DEG = 3.0
