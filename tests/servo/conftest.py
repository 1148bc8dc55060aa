"""The control law of the micro delta, on a joint that is nothing but an inertia."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.robot_file import RobotFile, load_robot
from deltactl.firmware_py.servo.law import JointLaw, LawSettings
from deltactl.models.robot import FloatArray
from deltactl.models.servo_drive import ServoDrive

MICRO = CONFIG_FOLDER / "uzunovic-2013.yaml"


@pytest.fixture(scope="session")
def micro() -> RobotFile:
    return load_robot(MICRO)


@pytest.fixture(scope="session")
def drive(micro: RobotFile) -> ServoDrive:
    assert isinstance(micro.drive, ServoDrive)
    return micro.drive


@pytest.fixture(scope="session")
def fine(drive: ServoDrive) -> LawSettings:
    """The law of the shipped robot with an encoder that hardly rounds and a drive without limit."""
    return replace(LawSettings.of(drive), rad_per_count=1e-9, current_limit_a=1e6)


@dataclass
class FreeJoint:
    """A rotor of an inertia, moved by current alone; the closed form over each period.

    What happens in a run is left in arrays: rotor angle (before the tick), current, estimate.
    """

    law: JointLaw
    settings: LawSettings
    inertia_kgm2: float
    torque_constant_nmpa: float
    disturbance_a: Callable[[float], float] = lambda t_s: 0.0
    gain: float = 1.0
    """What the current is multiplied by on its way, as a gain margin has it."""
    angle_rad: float = 0.0
    speed_radps: float = 0.0

    def run(self, seconds: float, reference_rad: Callable[[float], float]) -> list[FloatArray]:
        settings, rows = self.settings, []
        period_s, per_count = settings.period_s, settings.gear_ratio * settings.rad_per_count
        for tick in range(round(seconds / period_s)):
            t_s = tick * period_s
            reference = reference_rad(t_s) / settings.gear_ratio
            current = self.law.tick(reference, round(self.angle_rad / per_count))
            rows.append((self.angle_rad, current, self.law.disturbance_a))
            pushed = self.gain * current - self.disturbance_a(t_s)
            rate = self.torque_constant_nmpa * pushed / self.inertia_kgm2
            self.angle_rad += self.speed_radps * period_s + rate * period_s**2 / 2.0
            self.speed_radps += rate * period_s
        return list(np.array(rows).T)


@pytest.fixture(scope="session")
def joint(drive: ServoDrive) -> Callable[..., FreeJoint]:
    """Makes a joint as the law believes it to be, unless told otherwise; at rest at `start_rad`."""

    def make(settings: LawSettings, start_rad: float = 0.0, **different) -> FreeJoint:
        law = JointLaw(settings)
        per_count = settings.gear_ratio * settings.rad_per_count
        law.reset(0.0, round(start_rad / per_count))
        nominal = {
            "inertia_kgm2": drive.nominal_inertia_kgm2,
            "torque_constant_nmpa": drive.torque_constant_nmpa,
        }
        return FreeJoint(law, settings, angle_rad=start_rad, **(nominal | different))

    return make
