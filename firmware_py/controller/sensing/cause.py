"""One cause for what three ranges say against the counts: a motor, a sensor, or the drives' power.

Each cause predicts how the three ranges may change: a motor that lost counts moves the platform
along one column of the linkage's slopes, a sensor that lies changes its own range and no other,
and drives without power let all arms go the same way. All are fitted to the same three figures
with the same weights; the best comes first, with those after it that fit as well.

Limits: what two causes at once look like is called by neither name. Three ranges and three arms
leave nothing over: any three figures are those of some arms, so that a sensor is named only for
being the simplest explanation.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from deltactl.firmware_py.robot_file import RobotFile
from deltactl.models.calibrated_inverse import CalibratedInverse
from deltactl.models.robot import ARMS, AXES, FloatArray

LEAST_M = 0.0005
"""No range is known better: the sensors count whole millimetres."""
MODEL = 0.1
"""Part of a change that lengths, scales and the slopes' own bend may be wrong by."""
UNLIKE = 9.0
"""A cause whose misfit is larger than the best's by so much is not the one: three sigma."""
UNEQUAL, LEAST_PART = 0.5, 0.2
"""Arms that let go together move alike to about half, and none hardly at all beside the others."""
NO_FIT = 25.0
"""A best cause that leaves so much, over two figures, explains nothing."""
BEYOND_RAD = math.radians(20.0)
"""An arm may fall so far past `limits.arm_deg`, but no further: its joints would not let it."""


@dataclass(frozen=True, slots=True, eq=False)
class Cause:
    """What it would be, how large, and how badly it fits."""

    kind: Literal["motor", "sensor", "power", "unknown"]
    place: int
    """Number of the motor or sensor, from 0; for the power, the arm that moved most."""
    angles_rad: FloatArray
    """How far the arms would be from their counts, (3,)."""
    range_m: float
    """How far the sensor would read wrong."""
    misfit: float
    """Sum of squares in standard deviations, over two figures."""


def causes(
    robot: RobotFile,
    angles_rad: FloatArray,
    change_m: FloatArray,
    scatter_m: FloatArray,
    slopes_m: FloatArray,
) -> list[Cause]:
    """The cause that explains a change of the ranges best, and those no worse by much.

    angles_rad: (3,), where the counts put the arms. change_m: (3,), what the ranges changed
    beyond the counts. scatter_m: (3,), its standard deviation by noise. slopes_m: (3, 3), change
    of each range with a radian of each arm. Arms and drives come before sensors that fit as well.
    """
    size_m = float(np.abs(change_m).max())
    sigma_m = np.sqrt(scatter_m**2 + LEAST_M**2 + (MODEL * size_m) ** 2 / 3.0)
    low_rad, high_rad = np.deg2rad(robot.limits.arm_deg)
    low_rad = min(low_rad, float(angles_rad.min())) - BEYOND_RAD
    high_rad = max(high_rad, float(angles_rad.max())) + BEYOND_RAD
    tried = [
        one
        for one in (
            *_of_one_sensor(change_m / sigma_m, change_m),
            *_of_one_motor(change_m / sigma_m, slopes_m / sigma_m[:, np.newaxis]),
            *_of_all_drives(robot, angles_rad, change_m),
        )
        if (angles_rad + one.angles_rad >= low_rad).all()
        and (angles_rad + one.angles_rad <= high_rad).all()
    ]
    best = min(one.misfit for one in tried)
    if best > NO_FIT:
        return [Cause("unknown", 0, np.zeros(3), 0.0, best)]
    found = [one for one in tried if one.misfit <= best + UNLIKE]
    return sorted(found, key=lambda one: (one.kind == "sensor", one.misfit))


def _of_one_sensor(weighted: FloatArray, change_m: FloatArray) -> Iterator[Cause]:
    for axis in range(len(AXES)):
        others = np.delete(weighted, axis)
        yield Cause("sensor", axis, np.zeros(3), float(change_m[axis]), float(others @ others))


def _of_one_motor(weighted: FloatArray, slopes: FloatArray) -> Iterator[Cause]:
    for motor in range(ARMS):
        column = slopes[:, motor]
        square = float(column @ column)
        turned_rad = float(column @ weighted) / square if square > 0.0 else 0.0
        left = weighted - column * turned_rad
        yield Cause("motor", motor, turned_rad * np.eye(ARMS)[motor], 0.0, float(left @ left))


def _of_all_drives(
    robot: RobotFile, angles_rad: FloatArray, change_m: FloatArray
) -> Iterator[Cause]:
    """Where the ranges put the arms, by the whole geometry: arms that fall go far."""
    assert robot.sensors is not None
    inverse = CalibratedInverse(robot)
    try:
        moved_m = np.linalg.solve(robot.sensors.axes, change_m)
    except np.linalg.LinAlgError:
        return
    position_m = inverse.position_m(angles_rad[np.newaxis]) + moved_m
    turned_rad = inverse.angles_rad_at_once(position_m)[0] - angles_rad
    if not np.isfinite(turned_rad).all():
        return
    size_rad, middle_rad = np.abs(turned_rad), float(turned_rad.mean())
    together = abs(np.sign(turned_rad).sum()) == ARMS
    if together and size_rad.min() >= LEAST_PART * size_rad.max():
        apart = (turned_rad - middle_rad) / (UNEQUAL * middle_rad)
        yield Cause("power", int(size_rad.argmax()), turned_rad, 0.0, float(apart @ apart))


def in_words(robot: RobotFile, found: Sequence[Cause]) -> str:
    """What it may be, of arms that are not homed: 'arm 2 is 9 degrees from its steps'."""
    return ", or ".join(dict.fromkeys(_of_one(robot, one) for one in found))


def _of_one(robot: RobotFile, cause: Cause) -> str:
    if cause.kind == "sensor":
        much = "too much" if cause.range_m > 0.0 else "too little"
        return (
            f"sensor {AXES[cause.place]} reads {abs(cause.range_m) * 1e3:.0f} mm {much}"
            " for the steps sent"
        )
    if cause.kind == "motor":
        degrees = math.degrees(abs(float(cause.angles_rad[cause.place])))
        return f"arm {cause.place + 1} is {degrees:.0f} degrees from where its steps should be"
    if cause.kind == "power":
        return "all arms are away from their steps: the drives have no power"
    return "the sensors contradict the steps and each other: check the sensors, then the motors"
