"""What a recording could not show, and from which size on it shows the rest."""

from __future__ import annotations

from typing import Any

from deltactl.diagnosis.answer.records import SmallestDetectable
from deltactl.models.robot import ServoAxis
from tests.diagnosis_report.conftest import report_text


def test_what_it_could_not_see_and_from_which_size_on_it_sees_is_in_peoples_units(
    make: Any,
) -> None:
    text = report_text(make("explained"))
    assert "A periodic error of the angle encoder of motor 1" in text
    assert "Backlash in the gear or coupling of motor 2 0.17 degrees" in text
    assert "A wrong gear ratio of motor 1 0.30 %" in text
    assert "softer than 35000 N m/rad" in text


def test_a_limit_of_what_the_file_has_is_of_more_of_it(make: Any) -> None:
    """Softer than 69 N m/rad, of an axis that the robot file gives 51.5."""
    axis = ServoAxis.model_validate(
        {
            "kind": "servo_axis", "name": "elbow", "motion": "rotary",
            "effects": ({"effect": "joint_compliance", "component": "axis",
                         "parameters": {"stiffness": 51.5}},),
        }
    )  # fmt: skip
    least = SmallestDetectable(
        effect="joint_compliance", component="axis", parameter="stiffness", value=69.0,
        unit="N m/rad",
    )  # fmt: skip
    answer = make("nothing_missing", findings=[], smallest_detectable=[least])
    text = report_text(answer, axis)
    assert "urther yielding of the axis under load softer than 69 N" in text
    without = axis.model_copy(update={"effects": ()})
    assert "arts of the axis that yield under load softer than" in report_text(answer, without)
