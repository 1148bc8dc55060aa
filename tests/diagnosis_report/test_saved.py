"""What is said of a corrected robot file: how sure each part of it is, and what is left out."""

from __future__ import annotations

from typing import Any

import pytest

from deltactl.diagnosis.answer.corrected_robot import lasts
from deltactl.diagnosis.answer.records import (
    Alternative,
    Evidence,
    Finding,
    NextExperiment,
    ParameterResult,
    Where,
)
from deltactl.diagnosis.report.next_run import saved_lines, written
from deltactl.diagnosis.report.remedies import remedies
from deltactl.diagnosis.report.screen import sentences
from deltactl.diagnosis.report.templates import PAGE, PYTHON, TERMINAL, Ways, say
from tests.diagnosis_report.conftest import delta_robot


def found(
    effect: str,
    component: str,
    name: str,
    probability: float | None,
    *other_causes: tuple[str, float],
) -> Finding:
    return Finding(
        effect=effect,
        component=component,
        parameters={name: ParameterResult(value=0.01, ci95=[0.009, 0.011], unit="rad")},
        where=Where(axes=[], times_s=[]),
        evidence=Evidence(delta_chi2=100.0, p=1e-9),
        share_of_mismatch=0.9,
        alternatives=[
            Alternative(effect=other_cause, component=component, delta_chi2=1.0, probability=p)
            for other_cause, p in other_causes
        ],
        probability=probability,
    )


OWN = found("home_offset", "motor1", "angle", 0.999)


def test_what_is_taken_over_says_how_sure_it_is(make: Any) -> None:
    open_one = found("home_offset", "motor2", "angle", 0.55, ("gear_backlash", 0.45))
    answer = make("explained", findings=[OWN, open_one], next_experiment=None)
    assert written(answer, False) == "with 2 of 2 findings"
    (line,) = saved_lines(answer, False)
    assert line == (
        "In the robot file: 1 and 2 (the same correction for either cause, above 99 % sure to be"
        " right)"
    )


@pytest.mark.parametrize("ways", [TERMINAL, PAGE, PYTHON])
def test_a_page_speaks_of_its_buttons_and_a_terminal_of_commands(make: Any, ways: Ways) -> None:
    both = [OWN, found("home_offset", "motor2", "angle", 0.55, ("gear_backlash", 0.45))]
    lone = [found("home_offset", "axis", "angle", 0.999)]
    plan = NextExperiment(
        job={}, tells_apart=["home_offset motor2"], expected_delta_chi2=54.0, minutes=2.5
    )
    for findings in (both, lone):
        answer = make("explained", findings=findings, next_experiment=plan)
        lines = [*sentences(answer, delta_robot(), ways), *saved_lines(answer, False, ways)]
        assert say("do.change_nothing") not in lines
        text = "\n".join(lines)
        assert ("--" in text) == (ways is TERMINAL)
        assert ("button" in text) == (ways is PAGE)


def test_what_is_not_certain_is_in_no_file_of_the_page(make: Any) -> None:
    open_one = found("gear_ratio", "axis", "scale", 0.5, ("joint_compliance", 0.5))
    answer = make("explained", findings=[open_one])
    assert any("--save-robot" in line for line in sentences(answer, None))
    assert not any("corrected robot file" in line for line in sentences(answer, None, PAGE))


def test_an_even_tie_of_a_lone_axis_is_left_out_until_it_is_asked_for(make: Any) -> None:
    tied = found("gear_ratio", "axis", "scale", 0.5, ("joint_compliance", 0.5))
    answer = make("explained", findings=[tied], next_experiment=None)
    assert written(answer, False) == "unchanged: nothing is certain enough"
    (line,) = saved_lines(answer, False)
    assert line.startswith(
        "Left out, not certain (--save-robot NEW.yaml --all writes it too): 1 (50 % sure)"
    )
    text = " ".join(sentences(answer))
    assert "measure how far it moves between two places, with its load" in text
    assert text.index("`gravity`") < text.index("with its load and without"), "what is cheap first"
    assert written(answer, True) == "with 1 of 1 findings"
    assert saved_lines(answer, True) == ["In the robot file: 1 (50 % sure)"]


@pytest.mark.parametrize(("effect", "size"), [("gear_ratio", "scale"), ("home_offset", "angle")])
def test_gravity_is_asked_for_only_where_the_robot_file_lacks_it(
    make: Any, effect: str, size: str
) -> None:
    tied = found(effect, "axis", size, 0.5, ("joint_compliance", 0.5))
    answer = make("explained", findings=[tied], next_experiment=None)
    for said, asked in ((False, True), (True, False)):
        one = answer.model_copy(update={"pull_said": said})
        text = "\n".join(sentences(one))
        assert ("`gravity`" in text) == asked
        assert ".." not in text


def test_a_likely_cause_of_a_lone_axis_is_not_said_to_be_corrected_whatever_it_is(
    make: Any,
) -> None:
    """Its file says what is known of the cause: another cause calls for another entry."""
    late = found("following_lag", "axis", "time", 0.82, ("viscous_friction", 0.18))
    answer = make("explained", findings=[late], next_experiment=None)
    (line,) = saved_lines(answer, False)
    assert line == "In the robot file: 1 (82 % sure)"
    (todo, *_) = remedies(answer)
    assert todo.startswith("Raise the gains")
    assert "right for either" not in todo


def test_what_no_robot_file_holds_is_named_with_the_reason(make: Any) -> None:
    nameless = found("unknown", "axis", "size_rms", 0.999)
    nameless = nameless.model_copy(update={"depends_on": ["speed"]})
    lost = found("lost_steps", "axis", "steps", 0.999)
    one = found("home_offset", "axis", "angle", 0.999)
    answer = make("explained", findings=[one, lost, nameless])
    assert written(answer, True) == "with 1 of 3 findings"
    assert saved_lines(answer, True) == [
        "In the robot file: 1",
        "Not written, as it happened once and is no property of the machine: 2",
        "Not written, as a robot file has entries only for what has a name: 3",
    ]


def test_without_a_probability_a_rival_makes_it_uncertain(make: Any) -> None:
    tied = found("transmission_error", "motor1", "amplitude", None)
    tied.alternatives.append(
        Alternative(effect="sensor_offset", component="range_x", delta_chi2=1.0)
    )
    plain = found("home_offset", "motor1", "angle", None)
    answer = make("explained", findings=[tied, plain], next_experiment=None)
    assert written(answer, False) == "with 1 of 2 findings"
    written_ones, left = saved_lines(answer, False)
    assert written_ones == "In the robot file: 2"
    assert left.endswith(": 1 (not certain)")


@pytest.mark.parametrize(
    ("effect", "component", "name", "stays"),
    [
        ("joint_friction", "axis", "torque", True),
        ("effort_offset", "axis", "offset", True),
        ("viscous_friction", "axis", "coefficient", True),
        ("joint_friction", "motor1", "torque", False),
        ("lost_steps", "axis", "steps", False),
        ("unknown", "axis", "size_rms", False),
    ],
)
def test_what_the_file_of_an_axis_can_say_is_taken_over(
    effect: str, component: str, name: str, stays: bool
) -> None:
    assert lasts(found(effect, component, name, 0.99)) is stays
