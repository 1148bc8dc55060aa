"""A servo delta read backwards: from its measured motion to what its disturbance observer says.

Motors, gears and linkage obey (Uzunovic 2013, equations 3 and 4, at the arm's shaft, with the
gear ratio N, the torque constant K, nominal inertia m_n and current i)

    N K i = M a'' + N^2 J a'' + c + g + friction
    disturbance = N K i - N^2 m_n a''

so the estimate of the observer, times N K, is what all of that is beyond the nominal inertia. The
observer sees it a little late: 1 / its bandwidth.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from deltactl.foundation.errors import ConfigError
from deltactl.models.chain.active import Active, activate, at
from deltactl.models.dynamics import mass_matrix_kgm2, velocity_torque_nm
from deltactl.models.effects.flow import BoolArray, Load, TorqueFlow
from deltactl.models.effects.kind import Port
from deltactl.models.effects.servo_joints import PAYLOAD
from deltactl.models.gravity import gravity_torque_nm, torque_per_kg_nm
from deltactl.models.linkage import Linkage, forward
from deltactl.models.robot import DeltaRobot, FloatArray
from deltactl.models.servo_drive import ServoDrive

PORTS = (Port.PLATFORM, Port.ARM, Port.GEAR, Port.MOTOR)
"""From the load back to the motor."""


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """A measured motion; arrays (n,) and (n, 3). `fresh` where a new stretch starts."""

    t_s: FloatArray
    fresh: BoolArray
    angle_rad: FloatArray
    speed_radps: FloatArray
    acceleration_radps2: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Course:
    """A motion with what the robot file says it takes, (n, 3) each."""

    motion: Motion
    torque_nm: FloatArray
    """Torque for the arms, rotors and friction."""
    per_kg_nm: FloatArray
    nominal_nm: FloatArray
    """What the observer takes for acceleration: N^2 m_n a''."""


class ServoChain:
    """One servo delta whose masses are known. Raises ConfigError for any other robot.

    Of the robot file's `effects` a payload counts here; the others are no torques.
    """

    def __init__(self, robot: DeltaRobot):
        if not isinstance(robot.drive, ServoDrive) or robot.masses is None:
            raise ConfigError(
                f"robot '{robot.name}': reading disturbances needs `drive: {{kind: servo, ...}}` "
                "and `masses` in the robot file"
            )
        self.robot, self.drive, self._masses = robot, robot.drive, robot.masses
        self._linkage = Linkage.of(robot.geometry)
        self._known = [
            activate(PAYLOAD, entry.component, {"mass": entry.parameters["mass"]})
            for entry in robot.effects
            if entry.effect == PAYLOAD.name
        ]
        self.rotor_kgm2 = robot.drive.gear_ratio**2 * robot.drive.rotor_inertia_kgm2

    @property
    def torque_per_ampere_nm(self) -> float:
        """At the arm: N K."""
        return self.drive.gear_ratio * self.drive.torque_constant_nmpa

    @property
    def late_s(self) -> float:
        """How late the observer's estimate is."""
        return 1.0 / self.drive.disturbance_bandwidth_radps

    def course(self, motion: Motion) -> Course:
        """What a motion takes by the robot file."""
        position_m = forward(self._linkage, motion.angle_rad).position_m
        drive = self.drive
        own = self._linkage_nm(motion, position_m, 0.0)
        per_kg = self._linkage_nm(motion, position_m, 1.0) - own
        dry = drive.gear_ratio * drive.coulomb_nm * np.sign(motion.speed_radps)
        wet = drive.gear_ratio**2 * drive.viscous_nmsprad * motion.speed_radps
        rotors = self.rotor_kgm2 * motion.acceleration_radps2
        nominal = drive.gear_ratio**2 * drive.nominal_inertia_kgm2 * motion.acceleration_radps2
        return Course(motion, own + rotors + dry + wet, per_kg, nominal)

    def disturbance_nm(self, course: Course, effects: Iterable[Active] = ()) -> FloatArray:
        """What the observer would say, times N K; (n, 3) [N m at the arm]. Not yet late."""
        motion = course.motion
        flow = TorqueFlow(
            t_s=motion.t_s,
            fresh=motion.fresh,
            start_s=float(motion.t_s[0]),
            angles_rad=course.torque_nm.copy(),
            load_of=lambda: Load(np.zeros_like(course.torque_nm), course.per_kg_nm),
            turned_rad=motion.angle_rad,
            speed_radps=motion.speed_radps,
            direction=np.sign(motion.speed_radps),
            acceleration_radps2=motion.acceleration_radps2,
            per_kg_nm=course.per_kg_nm,
            rotor_kgm2=self.rotor_kgm2,
        )
        active = [*self._known, *effects]
        for port in PORTS:
            for effect in at(active, port):
                effect.act(flow)
        torque: FloatArray = flow.angles_rad - course.nominal_nm
        return torque

    def _linkage_nm(self, motion: Motion, position_m: FloatArray, payload_kg: float) -> FloatArray:
        """M a'' + c + g of arms, rods and platform, (n, 3)."""
        given = (self._linkage, self._masses, motion.angle_rad, position_m)
        matrix = mass_matrix_kgm2(*given, payload_kg)
        speeding = (matrix @ motion.acceleration_radps2[..., None])[..., 0]
        turning = velocity_torque_nm(*given, motion.speed_radps, payload_kg)
        per_kg = torque_per_kg_nm(self._linkage, motion.angle_rad, position_m)
        weight = gravity_torque_nm(*given, payload_kg, per_kg)
        torque: FloatArray = speeding + turning - weight
        return torque
