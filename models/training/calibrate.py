"""Calibration: the physical model that explains measured positions best, and its inverse.

A network that maps measured positions to angles takes the noise of the sensors for part of its
input. Here the robot's own direction is fitted, from exact counts to noisy positions: lengths,
directions and zero of every arm, what yields under gravity, the gears' once-a-turn error, and
the sensors' own offset, scale, direction and curvature. Every parameter has a plausible size,
used as a prior: it says who is to blame where the data cannot (maximum a posteriori).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from deltactl.foundation.errors import NetworkError
from deltactl.foundation.scatter import MAD_TO_SIGMA
from deltactl.models.gravity import gravity_torque_nm
from deltactl.models.linkage import Linkage, forward, inverse
from deltactl.models.robot import ARMS, DeltaRobot, FloatArray
from deltactl.models.training import levenberg_marquardt

_PASSES = 4
"""Fits with new weights of outliers and new gravity torques."""
_ITERATIONS = 15
_ENOUGH = 1e-9
_HUBER = 2.5
"""Beyond this many deviations a sample counts less (Huber 1964)."""
_SETTLE = 4
"""Rounds of the inverse's fixed point; each gains two digits or more."""


@dataclass(frozen=True)
class Plausible:
    """How far from the robot file a parameter may well be: standard deviations of the priors."""

    length: float = 0.02
    """Part of the upper arm's length."""
    azimuth_rad: float = 0.03
    home_rad: float = 0.3
    compliance_rad_per_nm: float = 2e-3
    gear_rad: float = 2e-3
    sensor_offset_m: float = 0.015
    """Zhao 2023, Table 2: a VL53L1X ranges to +-25 mm."""
    sensor_scale: float = 0.005
    """A uniform scale of the robot looks like one of the sensors: this and `length` divide it."""
    sensor_turn_rad: float = 0.01
    """A bracket bent by half a degree."""
    sensor_curvature_per_m: float = 0.005
    """Cross talk; 0.5 mm at a reach of 0.3 m."""


@dataclass(frozen=True, eq=False)
class Calibrated:
    """A robot as found: a linkage, what yields, the gears and the sensors."""

    robot: DeltaRobot
    linkage: Linkage
    compliance_rad_per_nm: FloatArray
    """(3,)."""
    gear_rad: FloatArray
    """(2, 3): sine and cosine parts of an error once in a turn of each motor."""
    sensor_offset_m: FloatArray
    sensor_matrix: FloatArray
    """(3, 3): measured less true position, by true position."""
    sensor_curvature_per_m: FloatArray
    noise_m: float = 0.0
    """Standard deviation of what is left, outliers aside."""

    def position_m(self, angles_rad: FloatArray) -> FloatArray:
        """Where the platform is, (n, 3), at commanded angles (n, 3)."""
        return self._position_m(angles_rad, self._torque_nm(angles_rad))

    def measured_m(self, angles_rad: FloatArray) -> FloatArray:
        """What the sensors say then, (n, 3)."""
        return self._seen_m(self.position_m(angles_rad))

    def angles_rad_many(self, position_m: FloatArray) -> FloatArray:
        """Commanded angles (n, 3) that bring the platform to positions (n, 3); NaN if none do."""
        wanted_rad = inverse(self.linkage, position_m).angles_rad
        angles_rad = wanted_rad.copy()
        torque_nm = self._torque_nm(wanted_rad)
        for _ in range(_SETTLE):
            np.subtract(wanted_rad, self._bent_rad(angles_rad, torque_nm), out=angles_rad)
        return angles_rad

    def _position_m(self, angles_rad: FloatArray, torque_nm: FloatArray) -> FloatArray:
        return forward(self.linkage, angles_rad + self._bent_rad(angles_rad, torque_nm)).position_m

    def _seen_m(self, position_m: FloatArray) -> FloatArray:
        turned_m: FloatArray = position_m @ self.sensor_matrix.T
        bowed_m: FloatArray = self.sensor_curvature_per_m * np.square(position_m)
        return position_m + self.sensor_offset_m + turned_m + bowed_m

    def _bent_rad(self, angles_rad: FloatArray, torque_nm: FloatArray) -> FloatArray:
        turn = _turns(self.robot) * angles_rad
        sine, cosine = self.gear_rad
        bent: FloatArray = (
            self.compliance_rad_per_nm * torque_nm + sine * np.sin(turn) + cosine * np.cos(turn)
        )
        return bent

    def _torque_nm(self, angles_rad: FloatArray) -> FloatArray:
        """Gravity's torque; 0 where the robot file has no masses, or the pose is singular."""
        if self.robot.masses is None:
            return np.zeros_like(angles_rad)
        position_m = forward(self.linkage, angles_rad).position_m
        torque = gravity_torque_nm(self.linkage, self.robot.masses, angles_rad, position_m)
        return np.nan_to_num(torque)


def calibrate(
    robot: DeltaRobot,
    position_m: FloatArray,
    angles_rad: FloatArray,
    plausible: Plausible | None = None,
) -> Calibrated:
    """Fit to measured positions (n, 3) [m] at commanded angles (n, 3) [rad].

    Raises NetworkError when the robot's linkage cannot be assembled at any of the angles.
    """
    layout = _Layout(robot, plausible or Plausible())
    found = layout.nominal()
    usable = np.isfinite(found.position_m(angles_rad)).all(axis=1)
    if usable.sum() < len(layout.deviation):
        raise NetworkError(
            f"robot '{robot.name}': only {int(usable.sum())} of {len(usable)} samples can be "
            "assembled with the file's lengths; is this the robot the data are of?"
        )
    position_m, angles_rad = position_m[usable], angles_rad[usable]
    numbers = layout.start()
    for _ in range(_PASSES):
        torque_nm = found._torque_nm(angles_rad)
        left_m = found._seen_m(found._position_m(angles_rad, torque_nm)) - position_m
        noise_m = float(MAD_TO_SIGMA * np.nanmedian(np.abs(left_m - np.nanmedian(left_m, axis=0))))
        weight = _weights(left_m, max(noise_m, 1e-9))
        numbers = _fit(layout, numbers, (position_m, angles_rad, torque_nm), weight)
        found = layout.calibrated(numbers, noise_m)
    return found


class _Layout:
    """Which number of the fit is what: numbers are in units of their plausible size."""

    def __init__(self, robot: DeltaRobot, plausible: Plausible):
        self.robot, p = robot, plausible
        length_m = p.length * float(np.mean(Linkage.of(robot.geometry).upper_arm_m))
        gear = p.gear_rad if _turns(robot) > 1.0 else 0.0
        yields = p.compliance_rad_per_nm if robot.masses is not None else 0.0
        parts = (
            *[(ARMS, length_m)] * 3,
            (ARMS, p.azimuth_rad),
            (ARMS, p.home_rad),
            (ARMS, yields),
            (2 * ARMS, gear),
            (ARMS, p.sensor_offset_m),
            (ARMS, p.sensor_curvature_per_m),
        )
        matrix = np.where(np.eye(ARMS) > 0.0, p.sensor_scale, p.sensor_turn_rad)
        sizes = np.concatenate([*(np.full(count, size) for count, size in parts), matrix.ravel()])
        self.fitted = np.flatnonzero(sizes)
        self.deviation = sizes[self.fitted]
        self.all = len(sizes)

    def start(self) -> FloatArray:
        """The robot file's own values."""
        return np.zeros(len(self.fitted))

    def nominal(self) -> Calibrated:
        """The robot file's robot."""
        return self.calibrated(self.start(), 0.0)

    def calibrated(self, numbers: FloatArray, noise_m: float) -> Calibrated:
        """What the numbers of a fit mean."""
        flat = np.zeros(self.all)
        flat[self.fitted] = numbers * self.deviation
        radius, upper, forearm, azimuth, home, yields = flat[:18].reshape(6, ARMS)
        nominal = Linkage.of(self.robot.geometry)
        linkage = Linkage(
            radius_m=nominal.radius_m + radius,
            upper_arm_m=nominal.upper_arm_m + upper,
            forearm_m=nominal.forearm_m + forearm,
            azimuth_rad=nominal.azimuth_rad + azimuth,
            home_offset_rad=nominal.home_offset_rad + home,
        )
        return Calibrated(
            robot=self.robot,
            linkage=linkage,
            compliance_rad_per_nm=yields,
            gear_rad=flat[18:24].reshape(2, ARMS),
            sensor_offset_m=flat[24:27],
            sensor_curvature_per_m=flat[27:30],
            sensor_matrix=flat[30:39].reshape(ARMS, ARMS),
            noise_m=noise_m,
        )


def _fit(
    layout: _Layout,
    start: FloatArray,
    data: tuple[FloatArray, FloatArray, FloatArray],
    weight: FloatArray,
) -> FloatArray:
    position_m, angles_rad, torque_nm = data

    def residuals(numbers: FloatArray) -> FloatArray:
        try:
            trial = layout.calibrated(numbers, 0.0)
        except ValueError:
            return np.full(position_m.size + len(numbers), np.inf)
        seen_m = trial._seen_m(trial._position_m(angles_rad, torque_nm))
        error = (seen_m - position_m) * weight
        # Off the linkage's workspace: far worse than any pose on it.
        error[~np.isfinite(error)] = 1e6
        return np.concatenate([error.ravel(), numbers])

    def jacobian(numbers: FloatArray) -> tuple[FloatArray, FloatArray]:
        here, step = residuals(numbers), 1e-5
        slopes = [(residuals(numbers + step * unit) - here) / step for unit in np.eye(len(numbers))]
        return here, np.stack(slopes, axis=1)

    numbers, before = start, np.inf
    for taken in levenberg_marquardt.steps(residuals, jacobian, start, damping=1e-3):
        numbers = taken.parameters
        if taken.iteration >= _ITERATIONS or before - taken.cost < _ENOUGH * taken.cost:
            break
        before = taken.cost
    return numbers


def _weights(left_m: FloatArray, noise_m: float) -> FloatArray:
    """Roots of weights over the noise: outliers count less, off-workspace poses not at all."""
    size = np.abs(np.nan_to_num(left_m - np.nanmedian(left_m, axis=0), nan=np.inf)) / noise_m
    root: FloatArray = np.sqrt(np.minimum(1.0, _HUBER / np.maximum(size, _HUBER))) / noise_m
    return root


def _turns(robot: DeltaRobot) -> float:
    """Motor turns per arm turn."""
    return 1.0 if robot.drive is None else robot.drive.gear_ratio
