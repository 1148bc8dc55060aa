"""A robot file that says that nothing pulls: no ratio or zero may then be what yields."""

from __future__ import annotations

import numpy as np
import pytest

from diagnosis.plants.lone.commanded_axis import CommandedAxis
from models.robot import AxisGravity, ServoAxis
from recording.tables.flat import FlatRecording

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
