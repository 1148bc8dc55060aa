"""From a finding without a name to the table that compensates it, when that is asked for."""

from __future__ import annotations

from enum import Enum

import numpy as np

from deltactl.diagnosis.answer.records import Finding, Table
from deltactl.models.effects import effect_kind
from deltactl.models.effects.tables import FROM_MIDDLE, JOINT_TABLE, PLATFORM_TABLE, SENSOR_TABLE
from deltactl.models.robot import AXES, DeltaRobot, EffectEntry

Values = dict[str, float | tuple[float, ...]]
PLACES = {
    **{f"range_{axis}": float(number) for number, axis in enumerate(AXES, start=1)},
    "range_x, range_y": FROM_MIDDLE,
}
ANGLE_NUMBERS = {f"theta_{number}": float(number) for number in (1, 2, 3)}


class Tables(Enum):
    """Which findings without a name become tables."""

    NONE = "none"
    JOINTS = "joints"
    """What enters at a joint."""
    SENSORS = "sensors"
    """Also what shows in one sensor, as its own error: it is expected there, and moves nothing."""
    PLATFORM = "platform"
    """Also what shows in one sensor: the user knows that the platform is off, not the sensor."""


def table_of(finding: Finding, robot: DeltaRobot, asked: Tables) -> EffectEntry | str:
    """The entry for a robot file, or why there is none."""
    if asked is Tables.NONE:
        return f"it has no name{_what_helps(finding, robot)}"
    if finding.table is None:
        return "it follows no quantity that a command has: no table of it can be made"
    if finding.has_memory:
        return "it depends on earlier motion too (hysteresis), which no table can hold"
    if finding.component.startswith("motor"):
        return _at_joint(finding, finding.table)
    if asked is Tables.JOINTS:
        return (
            "it shows in a sensor, and may be the sensor's (--tables platform, if you know that"
            " the platform is off)"
        )
    return _over_position(finding, finding.table, robot, asked)


def _what_helps(finding: Finding, robot: DeltaRobot) -> str:
    """Which tables would compensate it, or why none does."""
    if isinstance(table_of(finding, robot, Tables.JOINTS), EffectEntry):
        return " (--tables joints compensates it by a table over the joint's angle)"
    why = table_of(finding, robot, Tables.PLATFORM)
    if isinstance(why, EffectEntry):
        return (
            "; it shows in a sensor (--tables sensors accepts it there; --tables platform, if you"
            " know that the platform is off, and not the sensor)"
        )
    return f", and {why}"


def _at_joint(finding: Finding, table: Table) -> EffectEntry | str:
    if table.follows not in ANGLE_NUMBERS:
        return f"it follows {table.follows}: a joint's table is over the angle of an arm"
    return _entry(
        JOINT_TABLE.name, finding.component, table, {"follows": ANGLE_NUMBERS[table.follows]}
    )


def _over_position(
    finding: Finding, table: Table, robot: DeltaRobot, asked: Tables
) -> EffectEntry | str:
    if table.follows not in PLACES or robot.sensors is None:
        return f"it follows {table.follows}: the platform's table is over its place"
    values: Values = {"follows": PLACES[table.follows]}
    if asked is Tables.SENSORS:
        return _entry(SENSOR_TABLE.name, finding.component, table, values)
    axis = robot.sensors.axes[AXES.index(finding.component[-1])]
    values["direction"] = tuple(float(part) for part in axis)
    return _entry(PLATFORM_TABLE.name, PLATFORM_TABLE.components[0], table, values)


def _entry(effect: str, component: str, table: Table, more: Values) -> EffectEntry | str:
    kind = effect_kind(effect)
    if not np.ptp(table.size) or max(np.abs(table.size)) > kind.main.high:
        return f"its table goes beyond {kind.main.high:g} {kind.main.unit}, the most there may be"
    errors = tuple(round(size, 9) for size in table.size)
    values: Values = {"error": errors, "lowest": table.lowest, "highest": table.highest, **more}
    refused = kind.refuses
    why = refused({n: np.asarray(v) for n, v in values.items()}) if refused else ""
    return why or EffectEntry(effect=effect, component=component, parameters=values)
