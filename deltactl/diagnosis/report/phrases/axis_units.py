"""The units that covariates have, on the axes of charts and of tables, by the machine."""

from __future__ import annotations

import re

from deltactl.diagnosis.answer.records import Diagnosis, Finding
from deltactl.models.robot import DeltaRobot, RangeSensor, RobotModel, ServoAxis

_OF_A_DELTA: tuple[tuple[str, str], ...] = (
    (r"theta_[123]", "rad"),
    (r"(range|pos|position)_[xyz]|range_x, range_y", "m"),
    (r"(speed|velocity)_[123]", "rad/s"),
    (r"(speed|velocity)_(range|pos)_[xyz]", "m/s"),
    (r"(acceleration|accel)_[123]", "rad/s2"),
    (r"(torque|load)_[123]", "N m"),
    (r"current_[123]", "A"),
    (r"temp_c", "\u00b0C"),
)


def covariate_unit(name: str, robot: RobotModel) -> str:
    """The unit in the name's brackets, or what the contract says of such a machine; empty for a
    covariate that the contract does not know.
    """
    if found := re.search(r"[\[(]([^\])]*)[\])]\s*$", name):
        return found[1]
    if not isinstance(robot, DeltaRobot):
        return _of_a_lone_machine(robot).get(name, "")
    for pattern, known in _OF_A_DELTA:
        if re.fullmatch(pattern, name):
            return known
    return ""


def with_units(answer: Diagnosis, robot: RobotModel) -> Diagnosis:
    """The same answer, whose tables say what their places and sizes are in."""
    findings = [_with_units(one, robot) for one in answer.findings]
    return answer.model_copy(update={"findings": findings})


def _with_units(finding: Finding, robot: RobotModel) -> Finding:
    table, size = finding.table, next(iter(finding.parameters.values()), None)
    if table is None or size is None:
        return finding
    follows = "s" if table.follows == "time" else covariate_unit(table.follows, robot)
    units = {"follows_unit": follows, "unit": size.unit}
    return finding.model_copy(update={"table": table.model_copy(update=units)})


def _of_a_lone_machine(robot: RobotModel) -> dict[str, str]:
    linear = isinstance(robot, ServoAxis) and robot.motion == "linear"
    own = "m" if linear or isinstance(robot, RangeSensor) else "rad"
    load = "N" if linear else "N m"
    return {
        "position": own,
        "command": own,
        "distance": own,
        "speed": f"{own}/s",
        "velocity": f"{own}/s",
        "acceleration": f"{own}/s2",
        "load": load,
        "effort": load,
    }
