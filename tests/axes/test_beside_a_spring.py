"""A force by position that the robot file leaves out, beside effects with a name."""

from __future__ import annotations

from dataclasses import replace

from deltactl.diagnosis.api import diagnose_recordings
from deltactl.models.robot import ServoAxis
from tests.axes.axis_rigs import ForcedRig

AXIS = ServoAxis(kind="servo_axis", name="sled", motion="linear", inertia=2.0)
N_PER_M = 40.0


def test_friction_beside_a_spring_is_as_sure_as_by_itself() -> None:
    """It was called a part of the spring, for a delta's unknown may have any shape."""
    log = ForcedRig(coulomb=2.0, viscous=8.0).record(3, span_s=20.0)
    pulled = log.columns["effort"] + N_PER_M * log.columns["position"]
    answer = diagnose_recordings(AXIS, [replace(log, columns={**log.columns, "effort": pulled})])
    sure = {one.effect: one.probability or 0.0 for one in answer.findings}
    assert "unknown" in sure
    assert min(sure["joint_friction"], sure["viscous_friction"]) > 0.9
