"""A robot file that says that nothing pulls: no ratio or zero may then be what yields."""

from __future__ import annotations

import numpy as np
import pytest

from deltactl.diagnosis.api import diagnose_recordings
from deltactl.diagnosis.plants.lone.commanded_axis import CommandedAxis
from deltactl.models.robot import KINDS, AxisGravity, ServoAxis, StepperAxis
from deltactl.recording.tables.flat import FlatRecording

T_S = 0.02 * np.arange(1000)
ASKED_RAD = 0.8 * np.sin(T_S)


def alternatives(gravity: AxisGravity | None, load_nm: float = 0.0) -> set[str]:
    """What a wrong ratio, and a wrong zero as well, may be instead, on an axis that turns."""
    axis = ServoAxis(kind="servo_axis", name="arm", motion="rotary", gravity=gravity)
    columns = {"command": ASKED_RAD, "position": 0.97 * ASKED_RAD}
    if load_nm:
        columns["load"] = np.full(len(T_S), load_nm)
    plant = CommandedAxis(axis, [FlatRecording(T_S, columns)])
    (why,) = (one.why for one in plant.not_testable() if one.effect == "joint_compliance")
    assert ("nothing pulls" in why) == (gravity is not None and not load_nm)
    ratio, home = (
        {same.effect for one in plant.regressors if one.key == key for same in one.equivalents}
        for key in ("ratio", "offset")
    )
    assert ("joint_compliance" in ratio) == ("joint_compliance" in home)
    return ratio


def test_what_pulls_may_be_meant_unless_it_is_said_that_nothing_does() -> None:
    assert "joint_compliance" in alternatives(None)
    assert "joint_compliance" not in alternatives(AxisGravity())


@pytest.mark.parametrize("gravity", [None, AxisGravity()])
def test_a_load_that_never_changes_may_hide_another(gravity: AxisGravity | None) -> None:
    assert "joint_compliance" in alternatives(gravity, load_nm=1.0)


def test_who_said_what_pulls_is_not_asked_for_it() -> None:
    """Nor is the owner of a stepper axis, whose robot file has no such entry."""
    alike = FlatRecording(T_S, {"command": ASKED_RAD, "position": 0.97 * ASKED_RAD})
    slide = {"kind": "servo_axis", "name": "slide", "motion": "linear"}
    stepper = {"kind": "stepper_axis", "name": "table"}
    for said, told in (
        (slide, "it needs `gravity` in the robot file, or a column `load`"),
        (slide | {"gravity": {"force_n": 12.0}}, "is the same everywhere"),
        (stepper, "it needs a column `load`"),
    ):
        robot = KINDS[str(said["kind"])].model_validate(said)
        assert isinstance(robot, ServoAxis | StepperAxis)
        if isinstance(robot, StepperAxis):
            columns = {"command_1": ASKED_RAD, "theta_1": 0.97 * ASKED_RAD}
            alike = FlatRecording(T_S, columns)
        plant = CommandedAxis(robot, [alike])
        (why,) = (one.why for one in plant.not_testable() if one.effect == "joint_compliance")
        assert told in why


@pytest.mark.study
@pytest.mark.parametrize("gravity", [None, AxisGravity()])
def test_an_answer_knows_whether_the_robot_file_says_what_pulls(
    gravity: AxisGravity | None,
) -> None:
    axis = ServoAxis(kind="servo_axis", name="arm", motion="rotary", gravity=gravity)
    noise = 1e-3 * np.random.default_rng(0).standard_normal(len(T_S))
    seen = FlatRecording(T_S, {"command": ASKED_RAD, "position": ASKED_RAD + noise})
    assert diagnose_recordings(axis, [seen]).pull_said == (gravity is not None)
