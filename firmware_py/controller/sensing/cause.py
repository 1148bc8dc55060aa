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
from deltactl.models.robot import AXES, FloatArray

LEAST_M = 0.0005
"""No range is known better: the sensors count whole millimetres."""
MODEL = 0.1
"""Part of a change that lengths, scales and the slopes' own bend may be wrong by."""
UNLIKE = 9.0
"""A cause whose misfit is larger than the best's by so much is not the one: three sigma."""
MORE_FREE = 9.0
"""What a further free figure must gain, so that a single cause goes first where it will do."""
NO_FIT = 25.0
"""A best cause that leaves so much, over two figures, explains nothing."""


@dataclass(frozen=True, slots=True, eq=False)
class Cause:
    """What it would be, how large, and how badly it fits."""

    kind: Literal["motor", "sensor", "power", "unknown"]
    place: int
    """Of the motor or the sensor, from 0; of the power, the arm that moved most."""
    angles_rad: FloatArray
    """How far the arms would be from their counts, (3,)."""
    range_m: float
    """How far the sensor would read wrong."""
    misfit: float
    """Sum of squares in standard deviations, and `MORE_FREE` for each figure beyond one."""


def causes(
    robot: RobotFile, change_m: FloatArray, scatter_m: FloatArray, slopes_m: FloatArray
) -> list[Cause]:
    """The cause that explains a change of the ranges best, and those no worse by much.

    change_m: (3,), what the ranges changed beyond the counts. scatter_m: (3,), its standard
    deviation by noise. slopes_m: (3, 3), change of each range with a radian of each arm.
    """
    size_m = float(np.abs(change_m).max())
    sigma_m = np.sqrt(scatter_m**2 + LEAST_M**2 + (MODEL * size_m) ** 2 / 3.0)
    widest_rad = math.radians(robot.limits.arm_deg[1] - robot.limits.arm_deg[0])
    tried = [
        one
        for one in _tried(change_m, sigma_m, slopes_m)
        if np.abs(one.angles_rad).max() <= widest_rad
    ]
    tried.sort(key=lambda one: one.misfit)
    if tried[0].misfit > NO_FIT:
        return [Cause("unknown", 0, np.zeros(3), 0.0, tried[0].misfit)]
    return [one for one in tried if one.misfit <= tried[0].misfit + UNLIKE]


def _tried(change_m: FloatArray, sigma_m: FloatArray, slopes_m: FloatArray) -> Iterator[Cause]:
    weighted = change_m / sigma_m
    for axis in range(len(AXES)):
        others = np.delete(weighted, axis)
        misfit = float(others @ others)
        yield Cause("sensor", axis, np.zeros(3), float(change_m[axis]), misfit)
    for motor in range(3):
        column = slopes_m[:, motor] / sigma_m
        square = float(column @ column)
        turned_rad = float(column @ weighted) / square if square > 0.0 else 0.0
        left = weighted - column * turned_rad
        yield Cause("motor", motor, turned_rad * np.eye(3)[motor], 0.0, float(left @ left))
    try:
        turned = np.linalg.solve(slopes_m, change_m)
    except np.linalg.LinAlgError:
        return
    if (turned > 0.0).all() or (turned < 0.0).all():
        worst = int(np.argmax(np.abs(turned)))
        yield Cause("power", worst, turned, 0.0, 2.0 * MORE_FREE)


def in_words(robot: RobotFile, found: Sequence[Cause]) -> str:
    """What it may be, of arms that are not homed: 'arm 2 is 9 degrees from its steps'."""
    return ", or ".join(dict.fromkeys(_of_one(robot, one) for one in found))


def _of_one(robot: RobotFile, cause: Cause) -> str:
    if cause.kind == "sensor":
        return sensor_says(cause.place, cause.range_m)
    if cause.kind == "motor":
        degrees = math.degrees(abs(float(cause.angles_rad[cause.place])))
        return f"arm {cause.place + 1} is {degrees:.0f} degrees from where its steps should be"
    if cause.kind == "power":
        return "all arms are away from their steps: the drives have no power"
    return "the sensors contradict the steps and each other: check the sensors, then the motors"


def sensor_says(axis: int, range_m: float) -> str:
    """'sensor x reads 46 mm too much, ...'."""
    much = "too much" if range_m > 0.0 else "too little"
    return (
        f"sensor {AXES[axis]} reads {abs(range_m) * 1e3:.0f} mm {much},"
        " which the two others and the counts contradict"
    )
