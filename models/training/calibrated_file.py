"""A calibration as a robot file: lengths, directions and homes, and the effects beside them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import yaml

from deltactl.foundation.errors import RecordingError
from deltactl.foundation.plain_file import write_whole
from deltactl.foundation.strict_yaml import Document
from deltactl.models.effects.frame_tilt import EFFECT as TILT
from deltactl.models.effects.joint_compliance import EFFECT as COMPLIANCE
from deltactl.models.effects.kind import MOTORS, RANGES, EffectKind
from deltactl.models.effects.sensor_crosstalk import EFFECT as CROSSTALK
from deltactl.models.effects.sensor_offset import EFFECT as OFFSET
from deltactl.models.effects.sensor_scale import EFFECT as SCALE
from deltactl.models.effects.transmission_error import EFFECT as TRANSMISSION
from deltactl.models.network.metadata import fingerprint
from deltactl.models.robot import DeltaRobot, EffectEntry, FloatArray, Geometry, per_arm
from deltactl.models.training.calibrate import Calibrated

LEAST_YIELD_RAD_PER_NM = 1e-9
"""Gears do not push back: what looks like it is a stiff gear."""
SENSOR_ROUNDS = 4
"""Each leaves a hundredth of what the one before left."""


def calibrated_robot(found: Calibrated) -> DeltaRobot:
    """The robot with per-arm geometry and effects as found.

    What the vocabulary has no name for is left out: sensor directions that are not at right
    angles any more (they do not matter for where the platform is).
    """
    nominal, linkage = found.robot.geometry, found.linkage
    platform_m = per_arm(nominal.platform_radius_m)
    geometry = Geometry(
        base_radius_m=_three(linkage.radius_m + platform_m),
        platform_radius_m=nominal.platform_radius_m,
        upper_arm_m=_three(linkage.upper_arm_m),
        forearm_m=_three(linkage.forearm_m),
        azimuth_deg=_three(np.degrees(linkage.azimuth_rad)),
        home_offset_deg=_three(np.degrees(linkage.home_offset_rad)),
    )
    effects = (*_gears(found), *_sensors(found))
    return found.robot.model_copy(
        update={
            "geometry": geometry,
            "effects": effects,
            "calibrated_from": fingerprint(nominal),
        }
    )


def true_m(found: Calibrated, seen_m: FloatArray) -> FloatArray:
    """Where a calibrated robot is when its sensors see it at (n, 3) [m], same shape."""
    position_m = np.array(seen_m, dtype=np.float64)
    for _ in range(SENSOR_ROUNDS):
        angles_rad = found.angles_rad_many(position_m)
        position_m = position_m + seen_m - found.measured_m(angles_rad)
    return position_m


def save_calibrated(
    robot_file: Path, found: Calibrated, words: str, machine: str, out: Path
) -> None:
    """Write the robot file with the calibration. Raises RecordingError.

    `machine`: whose samples they are, in the words of the data set's settings. A job with
    `inverse_kinematics: {kind: calibrated}` takes all of it into account; networks trained on
    samples of that machine run with this file as well.
    """
    check_new(robot_file, out)
    document = Document.read(robot_file)
    robot = calibrated_robot(found)
    data = document.data | {
        "calibrated_from": robot.calibrated_from,
        "calibrated_on": machine,
        "geometry": robot.geometry.model_dump(mode="json"),
        "effects": [entry.model_dump(mode="json") for entry in robot.effects],
    }
    text = f"# {robot_file.name}, calibrated on {words}.\n{yaml.safe_dump(data, sort_keys=False)}"
    try:
        write_whole(out, text, fresh=True)
    except FileExistsError:
        raise RecordingError(f"{out}: exists already; name another file") from None
    except OSError as error:
        raise RecordingError(f"{out}: cannot be written ({error.strerror})") from error


def check_new(robot_file: Path, out: Path) -> None:
    """Before any work: raise RecordingError where `save_calibrated` could not write."""
    data = Document.read(robot_file).data
    if data.get("effects") or data.get("calibrated_from"):
        raise RecordingError(
            f"{robot_file}: has effects or a calibration already; calibrate with the file as it "
            "was designed"
        )
    if out.exists():
        raise RecordingError(f"{out}: exists already; name another file")
    if not out.parent.is_dir():
        raise RecordingError(f"{out}: cannot be written (no such folder)")


def _gears(found: Calibrated) -> list[EffectEntry]:
    entries = []
    drive = found.robot.drive
    period_rad = 2.0 * np.pi / (1.0 if drive is None else drive.gear_ratio)
    for arm, motor in enumerate(MOTORS):
        yields = float(found.compliance_rad_per_nm[arm])
        if yields > LEAST_YIELD_RAD_PER_NM:
            entries.append(_entry(COMPLIANCE, motor, stiffness=1.0 / yields))
        sine, cosine = found.gear_rad[:, arm]
        if sine != 0.0 or cosine != 0.0:
            entries.append(
                _entry(
                    TRANSMISSION,
                    motor,
                    amplitude=float(np.hypot(sine, cosine)),
                    period=float(period_rad),
                    phase=float(np.arctan2(cosine, sine)),
                )
            )
    return entries


def _sensors(found: Calibrated) -> list[EffectEntry]:
    """Errors by position, (x + o + m x + c x^2), as errors by distance d = D + x."""
    sensors = found.robot.sensors
    if sensors is None or not np.allclose(sensors.axes, np.eye(3)):
        return []
    matrix, entries = found.sensor_matrix, []
    turned = 0.5 * (matrix - matrix.T)
    rotation = (float(turned[2, 1]), float(turned[0, 2]), float(turned[1, 0]))
    entries.append(
        EffectEntry(effect=TILT.name, component="frame", parameters={"rotation": rotation})
    )
    for axis, name in enumerate(RANGES):
        far_m, bow = sensors.offsets_m[axis], found.sensor_curvature_per_m[axis]
        scale = 1.0 + matrix[axis, axis] - 2.0 * bow * far_m
        offset_m = far_m + found.sensor_offset_m[axis] - scale * far_m - bow * far_m**2
        entries += [
            _entry(CROSSTALK, name, curvature=float(bow / scale)),
            _entry(SCALE, name, scale=float(scale)),
            _entry(OFFSET, name, offset=float(offset_m)),
        ]
    return entries


def _entry(effect: EffectKind, component: str, **parameters: float) -> EffectEntry:
    return EffectEntry(effect=effect.name, component=component, parameters=dict(parameters))


def _three(values: FloatArray) -> tuple[float, float, float]:
    first, second, third = (float(value) for value in values)
    return first, second, third
