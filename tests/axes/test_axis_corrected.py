"""The saved robot file of a lone axis is one: with it, nothing is missing any more."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import pytest

from diagnosis.answer.corrected_robot import save_corrected
from diagnosis.pipelines.lone_machine import diagnose_axis
from models.robot import DeltaRobot, RobotModel, load_robot_model
from recording.tables.flat import FlatRecording

FOLLOWS = "kind: servo_axis\nname: follows\nmotion: rotary\n"
FORCED = "kind: servo_axis\nname: forced\nmotion: linear\ninertia: 2.0\n"
RANGES = "kind: range_sensor\nname: ranges\n"


def corrected(text: str, recording: FlatRecording, folder: Path) -> tuple[RobotModel, float]:
    """The robot file that a diagnosis saves, and the mismatch it was to explain."""
    path, out = folder / "robot.yaml", folder / "corrected.yaml"
    path.write_text(text, encoding="utf-8")
    belief = load_robot_model(path)
    assert not isinstance(belief, DeltaRobot)
    answer = diagnose_axis(belief, [recording])
    assert answer.findings
    save_corrected(path, answer, out, all_of_them=True)
    return load_robot_model(out), answer.fit.rms_before_m


@pytest.mark.parametrize(
    ("text", "rig", "wrong"),
    [
        (FOLLOWS, "FollowingRig", {"wave": 0.004, "period": 0.2}),
        (FOLLOWS, "FollowingRig", {"lag_s": 0.08}),
        (FORCED, "ForcedRig", {"viscous": 6.0}),
        (RANGES, "RangingRig", {"offset": 0.02}),
    ],
    ids=["periodic", "lag", "friction", "ranging"],
)
def test_with_the_saved_robot_the_mismatch_is_gone(
    rigs: ModuleType, tmp_path: Path, text: str, rig: str, wrong: dict[str, float]
) -> None:
    robot, before = corrected(text, getattr(rigs, rig)(**wrong).record(1), tmp_path)
    assert not isinstance(robot, DeltaRobot)
    again = diagnose_axis(robot, [getattr(rigs, rig)(**wrong).record(2)])
    assert again.findings == []
    assert again.fit.rms_before_m < 0.25 * before
    assert again.fit.rms_after_m < 1.1 * again.fit.noise_floor_m
