"""The verdict in one sentence, and how surely it is said."""

from __future__ import annotations

import math
from typing import Any

import pytest

from deltactl.diagnosis.answer.records import Unexplained
from deltactl.diagnosis.report.headline import headline
from deltactl.diagnosis.report.in_words import in_words
from deltactl.diagnosis.report.screen import sentences

VERDICTS = ("nothing_missing", "explained", "partly_explained", "unexplained")
NAN = math.nan


@pytest.mark.parametrize(
    ("verdict", "says"),
    [
        ("nothing_missing", "Nothing is missing"),
        (
            "explained",
            "The model error is explained by backlash in the gear or coupling of motor 2",
        ),
        (
            "partly_explained",
            "Part of the model error is explained by backlash in the gear or coupling",
        ),
        ("unexplained", "enters at motor 3 and follows the angle of arm 3"),
    ],
)
def test_the_verdict_comes_first(make: Any, verdict: str, says: str) -> None:
    lines = sentences(make(verdict))
    assert lines[0] == headline(make(verdict))
    assert says in lines[0]
    assert len(lines) > 4


def test_where_most_is_left_the_headline_says_so(make: Any) -> None:
    answer = make("partly_explained")
    most = answer.unexplained.model_copy(update={"share_of_mismatch": 0.9})
    says = headline(answer.model_copy(update={"unexplained": most}))
    assert says.startswith("Part of the model error is explained by")
    assert "; 2.2 mm of 4.1 mm is left (first check that each column" in says


def test_what_is_left_is_given_where_it_need_not_be_noise(make: Any) -> None:
    """Of an answer whose rest no test sees and that is more than readings at rest scatter by."""
    figures = make("explained").fit.model_copy(update={"scatter_within_m": 1e-6})
    fit = figures.model_copy(update={"rms_after_m": 0.3 * figures.rms_before_m})
    rest = Unexplained(share_of_mismatch=0.0)
    says = headline(make("explained", fit=fit, unexplained=rest))
    assert says.endswith("; 1.2 mm of 4.1 mm is left.")
    noise = {"findings": make("partly_explained").findings, "unexplained": rest}
    for verdict in ("explained", "partly_explained"):
        assert "left" not in headline(make(verdict, **noise))


def test_many_findings_are_counted_in_the_headline(make: Any, parts: Any) -> None:
    kinds = ["gear_backlash", "joint_friction", "home_offset", "gear_ratio"]
    many = [parts["backlash"](effect=kinds[k // 3], component=f"motor{k % 3 + 1}")
            for k in range(12)]  # fmt: skip
    assert "and 2 more, named below" in headline(make("explained", findings=many))
    assert "more" not in headline(make("explained", findings=many[:3]))
    assert "couplings of motors 1, 2 and 3" in headline(make("explained", findings=many[:3]))


@pytest.mark.parametrize(
    ("joints", "called"),
    [
        ([2, 1, 3, 5, 4, 6], "in joint 1 to joint 6"),
        ([1, 2, 4], "in joint 1, joint 2 and joint 4"),
        ([1, 2], "in joint 1 and joint 2"),
    ],
)
def test_joints_whose_numbers_follow_one_another_are_a_span(
    make: Any, parts: Any, joints: list[int], called: str
) -> None:
    one = parts["backlash"]
    many = [one(effect="joint_friction", component=f"joint_{k}", alternatives=[]) for k in joints]
    assert called in headline(make("explained", findings=many))


def test_both_frictions_of_an_axis_are_one_phrase(make: Any, parts: Any) -> None:
    dry, viscous = (
        parts["backlash"](effect=effect, component="axis", probability=0.999, alternatives=[])
        for effect in ("joint_friction", "viscous_friction")
    )
    says = headline(make("explained", findings=[dry, viscous]))
    assert says == "The model error is explained by dry and viscous friction in the axis."
    alone = headline(make("explained", findings=[viscous]))
    assert alone == "The model error is explained by viscous friction in the axis."


def test_more_than_noise_that_nothing_names_is_not_called_improbable(make: Any) -> None:
    faint = make("unexplained", findings=[], false_alarm_p=0.6, probability_nothing_missing=0.995)
    assert headline(faint).startswith("No known effect is missing (above 99 % sure); the remaining")
    assert "below 1 %" not in headline(faint)


def test_a_rest_that_no_test_sees_has_one_verdict(make: Any) -> None:
    """More than noise, too faint to say, and noise alone would look like this: of one recording."""
    figures = {"rms_before_m": 0.094, "rms_after_m": 0.094, "noise_floor_m": 0.072}
    fit = make("unexplained").fit.model_copy(update=figures)
    changes = {
        "findings": [], "false_alarm_p": 1.0, "probability_nothing_missing": 0.99,
        "unexplained": Unexplained(share_of_mismatch=1.0, p=1.0),
    }  # fmt: skip
    for done_m, little in ((4.0, True), (0.1, False), (0.0, False)):
        known = fit.model_copy(update={"done_by_known_m": done_m})
        answer = make("unexplained", fit=known, **changes)
        text = " ".join(sentences(in_words(answer)))
        assert headline(answer).startswith("No known effect is missing (99 % sure);")
        assert "noise alone" not in text
        assert ("too little to act on" in text) == little


def test_how_sure_it_is_that_nothing_is_missing_is_said_once(make: Any) -> None:
    answer = make(
        "nothing_missing", findings=[], false_alarm_p=1.0, probability_nothing_missing=0.67
    )
    text = " ".join(sentences(answer))
    assert text.count("67 % sure") == 1
    assert "A longer recording, with more moves and places, would tell more surely." in text


@pytest.mark.parametrize(
    ("sure", "says"),
    [(0.99, "Nothing is missing (99 %"), (0.68, "Probably nothing is missing (68 %")],
)
def test_nothing_is_as_sure_as_it_is_said_to_be(make: Any, sure: float, says: str) -> None:
    answer = make("nothing_missing", findings=[], probability_nothing_missing=sure)
    assert headline(answer).startswith(says)


def test_nothing_missing_beside_a_rest_of_no_noise_speaks_of_no_noise(make: Any) -> None:
    fit = make("nothing_missing").fit.model_copy(update={"scatter_within_m": 1e-6})
    says = headline(make("nothing_missing", findings=[], fit=fit))
    assert says.endswith("(2.2 mm) shows no pattern.")
    assert "behaves as its robot file says" not in says
