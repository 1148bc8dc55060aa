"""Errors without a name: a table over what they follow, at a joint or at the platform."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from deltactl.models.effects.card import Compensated, EffectCard, Rule
from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import MOTORS, EffectKind, Memory, Parameter, Port, Values, scalar
from deltactl.models.robot import FloatArray

STEEPEST = 0.5
"""Error per change of what it follows; a steeper table could not be turned round."""
MOST = 256
"""Places in one table."""
FROM_MIDDLE = 4.0
"""What a platform's table follows: 1, 2, 3 for x, y, z, or 4 for the distance from the z axis."""


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


def _refused(values: Values) -> str:
    if not scalar(values, "lowest") < scalar(values, "highest"):
        return "'lowest' must be less than 'highest'"
    if scalar(values, "follows") % 1.0:
        return "'follows' must be a whole number"
    if steepest(values) > STEEPEST:
        return f"the table changes by {steepest(values):.2g} a unit; {STEEPEST:g} is the most"
    return ""


def _at_joint(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    followed = flow.angles_rad[:, round(scalar(values, "follows")) - 1]
    flow.angles_rad[:, index] += looked_up(values, followed)


def _at_platform(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    flow.position_m = shifted(values, flow.position_m)


def shifted(values: Values, position_m: FloatArray) -> FloatArray:
    """Positions (n, 3) with the table's error added in its direction."""
    follows = scalar(values, "follows")
    if follows == FROM_MIDDLE:
        followed = np.hypot(position_m[:, 0], position_m[:, 1])
    else:
        followed = position_m[:, round(follows) - 1]
    direction = np.asarray(values["direction"], dtype=np.float64)
    moved: FloatArray = position_m + looked_up(values, followed)[:, np.newaxis] * direction
    return moved


def _joint_words(component: str, values: Mapping[str, Any]) -> str:
    most = math.degrees(float(np.abs(values["error"]).max()))
    return (
        f"{component} is off by up to {most:.3f} degrees, by a table over the angle of arm"
        f" {values['follows']:.0f}"
    )


def _platform_words(component: str, values: Mapping[str, Any]) -> str:
    most = 1e3 * float(np.abs(values["error"]).max())
    names = {1.0: "x", 2.0: "y", 3.0: "z", FROM_MIDDLE: "the distance from the middle"}
    return f"the platform is off by up to {most:.2f} mm, by a table over {names[values['follows']]}"


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
CARDS = tuple(
    EffectCard(
        name=kind.name, kind=kind, table=True, rule=Rule.TABLE, compensated=Compensated.INVERSE
    )
    for kind in (JOINT_TABLE, PLATFORM_TABLE)
)
