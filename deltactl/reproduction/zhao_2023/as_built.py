"""Reads `as_built.yaml` and makes the MuJoCo machine of it."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import Field

from deltactl.foundation.errors import ConfigError
from deltactl.foundation.strict_yaml import StrictModel, load
from deltactl.models.robot import DeltaRobot, FloatArray, Geometry, per_arm
from deltactl.proof.ranging import NOMINAL_OFFSET_M, Noise, Sensors
from deltactl.proof.recorded import Machine
from deltactl.proof.robot.as_built import AsBuilt, Bend, Body, Joints

AS_BUILT_FILE = Path(__file__).with_name("as_built.yaml")
ARCMIN_PER_DEG = 60.0

Three = tuple[float, float, float]
Positive = Annotated[float, Field(ge=0.0)]
AllPositive = tuple[Positive, Positive, Positive]


class BodyErrors(StrictModel):
    """Departures from the robot file, and the masses."""

    base_radius_mm: Three
    upper_arm_mm: Three
    forearm_mm: Three
    azimuth_deg: Three
    upper_arm_kg: Positive
    forearm_kg: Positive
    platform_kg: Positive


class JointErrors(StrictModel):
    """Drives, gears, bearings."""

    home_deg: Three
    play_arcmin: AllPositive
    stiffness_nm_per_rad: AllPositive
    friction_nm: AllPositive
    drag_nms_per_rad: AllPositive
    step_error_deg: Positive
    step_errors_per_turn: Positive
    gear_error_deg: AllPositive
    gear_errors_per_turn: Positive
    gear_phase_deg: Three


class SensorErrors(StrictModel):
    """Three distance sensors."""

    offset_mm: Three
    scale: Three
    curvature_per_m: Three
    turned_deg: Three
    sigma_mm: Positive
    correlation: Annotated[float, Field(ge=0.0, lt=1.0)]
    outliers: Annotated[float, Field(ge=0.0, le=0.2)]
    dropouts: Annotated[float, Field(ge=0.0, le=0.2)]


class AsBuiltFile(StrictModel):
    """How a robot departs from its file."""

    name: str
    robot: str
    body: BodyErrors
    joints: JointErrors
    sensors: SensorErrors

    @property
    def mark(self) -> str:
        """Name and digest, so that results of other parameters are never taken for these."""
        digest = hashlib.sha256(self.model_dump_json().encode()).hexdigest()[:12]
        return f"{self.name} {digest}"


def load_as_built(path: Path, robot: DeltaRobot) -> AsBuiltFile:
    """Read the file. Raises MissingFile or ConfigError, also when it is about another robot."""
    built = load(path, AsBuiltFile)
    if built.robot != robot.name:
        raise ConfigError(
            f"{path}: is about robot '{built.robot}', not '{robot.name}'; "
            "name the as-built file of this robot"
        )
    if robot.sensors is not None and (
        not np.allclose(robot.sensors.offsets_m, NOMINAL_OFFSET_M)
        or not np.allclose(robot.sensors.axes, np.eye(3))
    ):
        raise ConfigError(
            f"{path}: the simulated sensors are at {list(NOMINAL_OFFSET_M)} m along x, y, z; "
            "the robot file's sensors must too"
        )
    return built


def machine_of(built: AsBuiltFile, robot: DeltaRobot) -> Machine:
    """The robot and its sensors, with all departures."""
    sensors = built.sensors
    return Machine(
        AsBuilt(_body(built.body, robot.geometry), _joints(built.joints, robot)),
        Sensors(
            offset_m=1e-3 * np.array(sensors.offset_mm),
            scale=np.array(sensors.scale),
            curvature_per_m=np.array(sensors.curvature_per_m),
            turned_rad=np.radians(sensors.turned_deg),
        ),
        Noise(1e-3 * sensors.sigma_mm, sensors.correlation, sensors.outliers, sensors.dropouts),
    )


def _body(errors: BodyErrors, geometry: Geometry) -> Body:
    return Body(
        base_radius_m=per_arm(geometry.base_radius_m) + 1e-3 * np.array(errors.base_radius_mm),
        platform_radius_m=per_arm(geometry.platform_radius_m),
        upper_arm_m=per_arm(geometry.upper_arm_m) + 1e-3 * np.array(errors.upper_arm_mm),
        forearm_m=per_arm(geometry.forearm_m) + 1e-3 * np.array(errors.forearm_mm),
        azimuth_rad=geometry.azimuth_rad + np.radians(errors.azimuth_deg),
        upper_arm_kg=errors.upper_arm_kg,
        forearm_kg=errors.forearm_kg,
        platform_kg=errors.platform_kg,
    )


def _joints(errors: JointErrors, robot: DeltaRobot) -> Joints:
    assert robot.drive is not None
    return Joints(
        rad_per_step=robot.drive.rad_per_step,
        home_rad=np.radians(errors.home_deg),
        wave_rad=np.full(3, np.radians(errors.step_error_deg)),
        waves_per_turn=errors.step_errors_per_turn,
        play_rad=np.radians(np.array(errors.play_arcmin) / ARCMIN_PER_DEG),
        stiffness_nm_per_rad=np.array(errors.stiffness_nm_per_rad),
        friction_nm=np.array(errors.friction_nm),
        drag_nms_per_rad=np.array(errors.drag_nms_per_rad),
        bends=[_gear_error(errors)],
    )


def _gear_error(errors: JointErrors) -> Bend:
    size = np.radians(errors.gear_error_deg)
    phase = np.radians(errors.gear_phase_deg)

    def bend(angles_rad: FloatArray, t_s: FloatArray) -> FloatArray:
        turned: FloatArray = size * np.sin(errors.gear_errors_per_turn * angles_rad + phase)
        return turned

    return bend
