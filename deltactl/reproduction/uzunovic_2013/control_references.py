"""The two experiments of section 5 as the drives' references, at every tick of the loop."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from deltactl.foundation.process import PACKAGE
from deltactl.models.inverse_kinematics import InverseKinematics
from deltactl.models.network.inverse import InverseNetwork
from deltactl.models.robot import DeltaRobot, FloatArray
from deltactl.models.robot_files import load_delta
from deltactl.models.servo_drive import ServoDrive

ROBOT_FILE = PACKAGE / "config" / "uzunovic-2013.yaml"
NETWORK_FILE = PACKAGE / "models" / "trained" / "uzunovic-2013.tflite"
FREQUENCY_HZ = 0.2
CONTROL_ON_S = 1.0
"""Section 5: "control is activated at time instant t = 1 (s)"."""
PERIODS = 2


@dataclass(frozen=True, slots=True)
class Experiment:
    """One experiment: its curve, the figures that show it, and what the paper reached."""

    name: str
    x_m: float
    y_m: float
    z_m: float
    y_turns: float
    """How many times as fast as x the curve's y goes round."""
    reference_figure: int
    response_figure: int
    paper_percent: float
    """Largest tracking error as per cent of peak to peak, "for all joints"."""

    def position_m(self, t_s: FloatArray) -> FloatArray:
        """Reference of the platform, (n, 3)."""
        turn = 2.0 * np.pi * FREQUENCY_HZ * t_s
        return np.stack(
            [
                self.x_m * np.sin(turn),
                self.y_m * np.cos(self.y_turns * turn),
                -0.075 + self.z_m * np.sin(turn),
            ],
            axis=1,
        )


EXPERIMENTS = (
    Experiment("first", 0.0045, 0.003, 0.002, 1.0, 7, 8, 1.1),
    # The second one's z is cut off in print ("-0.075 +"): taken as constant.
    Experiment("second", 0.003, 0.003, 0.0, 2.0, 9, 10, 0.7),
)


@dataclass(frozen=True, slots=True, eq=False)
class References:
    """One experiment at every tick: times (n,), platform (n, 3), arm angles (n, 3)."""

    experiment: Experiment
    t_s: FloatArray
    position_m: FloatArray
    angle_rad: FloatArray

    @property
    def peak_to_peak_rad(self) -> FloatArray:
        """Of each joint's reference, (3,)."""
        ranges: FloatArray = np.ptp(self.angle_rad, axis=0)
        return ranges


def micro_delta() -> tuple[DeltaRobot, ServoDrive]:
    """The shipped robot file, and its drive."""
    robot = load_delta(ROBOT_FILE)
    assert isinstance(robot.drive, ServoDrive)
    return robot, robot.drive


def shipped_network() -> InverseNetwork:
    """The network inverse kinematics that comes with the robot file."""
    return InverseNetwork.open(NETWORK_FILE, micro_delta()[0])


def references(
    experiment: Experiment, inverse: InverseKinematics, period_s: float, seconds: float
) -> References:
    """Cartesian reference -> network -> arm angles, from t = 0. Raises what the network does."""
    t_s = np.arange(round(seconds / period_s)) * period_s
    position_m = experiment.position_m(t_s)
    return References(experiment, t_s, position_m, inverse.angles_rad_many(position_m))


def whole_s() -> float:
    """How long an experiment is simulated: until control is on, and whole periods of it."""
    return CONTROL_ON_S + PERIODS / FREQUENCY_HZ
