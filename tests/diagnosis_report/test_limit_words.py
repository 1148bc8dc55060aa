"""What a recording could not show, and from which size on it shows the rest."""

from __future__ import annotations

import math
from typing import Any

import pytest

from deltactl.diagnosis.answer.records import (
    Alternative,
    NotTestable,
    ParameterResult,
    SmallestDetectable,
)
from deltactl.diagnosis.report.summary import plain_lines
from deltactl.models.effects import VOCABULARY
from deltactl.models.robot import ServoAxis

VERDICTS = ("nothing_missing", "explained", "partly_explained", "unexplained")
NAN = math.nan


def test_what_it_could_not_see_is_grouped_and_what_it_could_is_in_peoples_units(make: Any) -> None:
    text = "\n".join(plain_lines(make("explained")))
    assert "could not show periodic errors of the angle encoders of motors 1, 2 and 3" in text
    assert "backlash in the gear or coupling of motor 2 (0.17 degrees)" in text
    assert "a wrong gear ratio of motor 1 (0.30 % off what the robot file says)" in text
    assert "softer than 35000 N m/rad" in text


def test_smallest_of_the_findings_come_first(make: Any) -> None:
    first = SmallestDetectable(
        effect="payload", component="platform", parameter="mass", value=0.02, unit="kg"
    )
    given = make("explained").smallest_detectable
    lines = plain_lines(make("explained", smallest_detectable=[first, *given]))
    line = next(line for line in lines if "Detection limits" in line)
    assert line.index("backlash") < line.index("mass")


def test_many_untested_effects_are_counted(make: Any) -> None:
    hidden = [NotTestable(effect=name, component="motor3", why="") for name in list(VOCABULARY)[:9]]
    text = "\n".join(plain_lines(make("explained", not_testable=hidden)))
    assert "5 more kinds of effect" in text
    text = "\n".join(plain_lines(make("explained", not_testable=hidden[:5])))
    assert "1 more kind of effect" in text


def test_a_rival_of_a_finding_is_shown_in_its_place_alone(make: Any, parts: Any) -> None:
    hidden = [NotTestable(effect="joint_compliance", component="motor1", why="no load")]
    rival = Alternative(effect="joint_compliance", component="motor1", delta_chi2=20.0)
    alone, tied = (
        "\n".join(plain_lines(make("explained", not_testable=hidden, findings=[found])))
        for found in (parts["backlash"](), parts["backlash"](alternatives=[rival]))
    )
    assert "could not show" in alone
    assert "other than in place of what was found: no load." in tied
    assert "other than" not in alone


def limit(component: str, value: float) -> SmallestDetectable:
    return SmallestDetectable(
        effect="home_offset", component=component, parameter="angle", value=value, unit="rad"
    )


def test_a_limit_is_said_once_for_all_joints_and_not_above_what_was_found(
    make: Any, parts: Any
) -> None:
    every = [limit("motor1", 0.001), limit("motor2", 0.002), limit("motor3", 0.001)]
    text = "\n".join(plain_lines(make("explained", smallest_detectable=every)))
    assert "motors 1, 2 and 3 (at most 0.11 degrees)" in text
    home = parts["backlash"](
        effect="home_offset", component="motor2",
        parameters={"angle": ParameterResult(value=-0.0005, ci95=[-0.0006, -0.0004], unit="rad")},
    )  # fmt: skip
    found = make("explained", smallest_detectable=every, findings=[home])
    assert "Detection limits" not in "\n".join(plain_lines(found))


@pytest.mark.parametrize("smallest", [1.003, 0.003])
@pytest.mark.parametrize(("found", "told"), [(0.98, True), (1.02, True), (1.001, False)])
def test_a_limit_of_a_scale_is_held_against_what_was_found_of_it(
    make: Any, parts: Any, smallest: float, found: float, told: bool
) -> None:
    least = SmallestDetectable(
        effect="gear_ratio", component="motor2", parameter="scale", value=smallest, unit="1"
    )
    ratio = parts["backlash"](
        effect="gear_ratio", component="motor2",
        parameters={"scale": ParameterResult(value=found, ci95=[0.9, 1.1], unit="1")},
    )  # fmt: skip
    answer = make("explained", smallest_detectable=[least], findings=[ratio])
    text = "\n".join(plain_lines(answer))
    assert ("(0.30 % off what the robot file says)" in text) == told


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
    text = "\n".join(plain_lines(answer, axis))
    assert "further yielding of the axis under load (as a second spring softer than 69 N" in text
    assert "parts of the axis that yield under load (softer than" in "\n".join(plain_lines(answer))
