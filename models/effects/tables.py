"""Errors without a name: a table over what they follow, at a joint, the platform or a sensor."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from deltactl.models.effects.card import Compensated, EffectCard, Rule
from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import (
    MOTORS,
    RANGES,
    EffectKind,
    Memory,
    Parameter,
    Port,
    Values,
    scalar,
)
from deltactl.models.effects.units_in_use import said
from deltactl.models.robot import FloatArray

STEEPEST = 0.5
"""Error per change of what it follows; a steeper table could not be turned round."""
MOST = 256
"""Places in one table."""
FROM_MIDDLE = 4.0
"""What tables of platform and sensors follow: 1, 2, 3 for x, y, z of the platform, or 4 for its
distance from the z axis."""


def looked_up(values: Values, at: FloatArray) -> FloatArray:
    """Errors at places (n,): linear between those of the table, constant beyond its ends."""
    size = np.asarray(values["error"], dtype=np.float64)
    places = np.linspace(scalar(values, "lowest"), scalar(values, "highest"), len(size))
    return np.interp(at, places, size)


def steepest(values: Values) -> float:
    """Largest change of the error per change of what it follows."""
    size = np.asarray(values["error"], dtype=np.float64)
    apart = (scalar(values, "highest") - scalar(values, "lowest")) / (len(size) - 1)
    return float(np.abs(np.diff(size)).max() / apart)


def _misread(values: Values) -> str:
    if not scalar(values, "lowest") < scalar(values, "highest"):
        return "'lowest' must be less than 'highest'"
    if scalar(values, "follows") % 1.0:
        return "'follows' must be a whole number"
    return ""


def _refused(values: Values) -> str:
    """A table that a motion has to turn round."""
    if why := _misread(values):
        return why
    if steepest(values) > STEEPEST:
        return f"the table changes by {steepest(values):.2g} a unit; {STEEPEST:g} is the most"
    return ""


def _at_joint(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    followed = flow.angles_rad[:, round(scalar(values, "follows")) - 1]
    flow.angles_rad[:, index] += looked_up(values, followed)


def _at_platform(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    flow.position_m = shifted(values, flow.position_m)


def _in_sensor(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    flow.ranges_m[:, index] += looked_up(values, _place(values, flow.position_m))


def shifted(values: Values, position_m: FloatArray) -> FloatArray:
    """Positions (n, 3) with the table's error added in its direction."""
    direction = np.asarray(values["direction"], dtype=np.float64)
    error_m = looked_up(values, _place(values, position_m))
    moved: FloatArray = position_m + error_m[:, np.newaxis] * direction
    return moved


def _place(values: Values, position_m: FloatArray) -> FloatArray:
    """What a table over the platform's position follows, (n,) [m]."""
    follows = scalar(values, "follows")
    if follows == FROM_MIDDLE:
        return np.hypot(position_m[:, 0], position_m[:, 1])
    return position_m[:, round(follows) - 1]


def _joint_words(component: str, values: Mapping[str, Any]) -> str:
    most = said(float(np.abs(values["error"]).max()), "rad")
    return (
        f"{component} is off by up to {most}, by a table over the angle of arm"
        f" {values['follows']:.0f}"
    )


def _platform_words(component: str, values: Mapping[str, Any]) -> str:
    return f"the platform is off by {_up_to(values)}"


def _sensor_words(component: str, values: Mapping[str, Any]) -> str:
    return f"{component} errs by {_up_to(values)} of the platform"


def _up_to(values: Mapping[str, Any]) -> str:
    most = 1e3 * float(np.abs(values["error"]).max())
    names = {1.0: "x", 2.0: "y", 3.0: "z", FROM_MIDDLE: "the distance from the middle"}
    return f"up to {most:.2f} mm, by a table over {names[values['follows']]}"


JOINT_TABLE = EffectKind(
    name="joint_table",
    port=Port.ARM,
    components=MOTORS,
    parameters=(
        Parameter("error", "rad", -0.1, 0.1, size=MOST, up_to=True),
        Parameter("lowest", "rad", -2.0 * np.pi, 2.0 * np.pi),
        Parameter("highest", "rad", -2.0 * np.pi, 2.0 * np.pi),
        Parameter("follows", "1", 1.0, 3.0),
    ),
    operate=_at_joint,
    says=_joint_words,
    order=-1,
    pose_alone=True,
    refuses=_refused,
)
PLATFORM_TABLE = EffectKind(
    name="platform_table",
    port=Port.PLATFORM,
    components=("platform",),
    parameters=(
        Parameter("error", "m", -0.05, 0.05, size=MOST, up_to=True),
        Parameter("lowest", "m", -10.0, 10.0),
        Parameter("highest", "m", -10.0, 10.0),
        Parameter("follows", "1", 1.0, FROM_MIDDLE),
        Parameter("direction", "1", -1.0, 1.0, size=3),
    ),
    operate=_at_platform,
    says=_platform_words,
    order=-1,
    pose_alone=True,
    refuses=_refused,
)
SENSOR_TABLE = EffectKind(
    name="sensor_table",
    port=Port.SENSOR,
    components=RANGES,
    parameters=PLATFORM_TABLE.parameters[:-1],
    operate=_in_sensor,
    says=_sensor_words,
    order=-1,
    pose_alone=True,
    refuses=_misread,
)
CARDS = tuple(
    EffectCard(name=kind.name, kind=kind, table=True, rule=Rule.TABLE, compensated=how)
    for kind, how in (
        (JOINT_TABLE, Compensated.INVERSE),
        (PLATFORM_TABLE, Compensated.INVERSE),
        (SENSOR_TABLE, Compensated.IN_READINGS),
    )
)
