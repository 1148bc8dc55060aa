"""Sentences are made from the fields, and say what these say."""

from __future__ import annotations

from typing import Any

import pytest

from deltactl.diagnosis.answer.records import Finding, PriorSensitivity, Unexplained
from deltactl.diagnosis.assessment.significance import as_found
from deltactl.diagnosis.report.fit import fit_line
from deltactl.diagnosis.report.in_words import in_words
from deltactl.diagnosis.report.screen import sentences
from deltactl.diagnosis.report.templates import say


def bare(finding: Finding) -> Finding:
    where = finding.where.model_copy(update={"regime": ""})
    return finding.model_copy(update={"says": "", "where": where})


def test_every_sentence_is_made(make: Any, parts: Any) -> None:
    findings = [bare(parts[name]()) for name in ("backlash", "lost_steps", "unknown")]
    answer = in_words(make("partly_explained", findings=findings, says=[]))
    backlash, steps, unknown = answer.findings
    assert "motor 2" in backlash.says
    assert backlash.where.regime == "after reversals and stops of motor 2"
    assert "32" in steps.says
    assert unknown.says.endswith("follows the angle of arm 3, with a size of 0.115 degrees "
                                 "(root mean square)")  # fmt: skip
    assert sentences(answer)[0].startswith("Part of the model error is explained by")


def test_what_cannot_be_distinguished_is_named(make: Any, parts: Any) -> None:
    tied = bare(parts["unknown"]()).model_copy(
        update={"depends_on": ["theta_3", "time"], "tied": ["time"]}
    )
    (finding,) = in_words(make("unexplained", findings=[tied])).findings
    assert "(or the time since the start: this recording cannot tell which)" in finding.says


@pytest.mark.parametrize(
    ("rest", "says"),
    [
        (
            Unexplained(share_of_mismatch=0.0, p=0.4),
            say("left.noise"),
        ),
        (
            Unexplained(share_of_mismatch=0.1, depends_on=["time"], component="range_x", p=1e-4),
            "The remaining error (2.2 mm) is more than noise and"
            " follows the time since the start at the x sensor",
        ),
        (
            Unexplained(share_of_mismatch=0.2, p=0.4),
            "The remaining error (2.2 mm) is more than noise and shows no pattern",
        ),
    ],
)
def test_what_is_left_is_said_as_it_is(make: Any, rest: Unexplained, says: str) -> None:
    assert in_words(make("partly_explained", unexplained=rest)).unexplained.says == says


def test_noise_is_what_is_left_of_the_whole_mismatch(make: Any) -> None:
    rest = Unexplained(share_of_mismatch=0.0, p=0.4)
    says = in_words(make("nothing_missing", findings=[], unexplained=rest)).unexplained.says
    assert says == say("left.noise")


@pytest.mark.parametrize("verdict", ["explained", "partly_explained", "nothing_missing"])
def test_what_goes_on_is_called_no_noise_of_a_sensor(make: Any, verdict: str) -> None:
    rest = Unexplained(share_of_mismatch=0.0, p=0.4)

    def says(correlation: float) -> str:
        figures = {"left_correlation": correlation, "left_apart_s": 0.01, "left_lasts_s": 0.11}
        fit = make("explained").fit.model_copy(update=figures)
        answer = in_words(make(verdict, fit=fit, unexplained=rest))
        return " ".join([answer.unexplained.says, fit_line(answer)])

    slow, quick = says(0.92), says(0.5)
    assert "readings within about 110 ms err alike (one reading every 10 ms was used)" in slow
    assert "of noise" not in slow
    assert "correlation" not in quick
    assert "2.10 mm of noise" in quick
    assert "is consistent with measurement noise" in quick
    assert "is consistent with measurement noise" not in slow


def test_what_known_effects_leave_is_said_in_one_piece(make: Any) -> None:
    """It was no noise of a sensor, and cannot be told from noise, and no more than may be left."""
    figures = {"left_correlation": 0.98, "left_apart_s": 0.16, "left_lasts_s": 2.1}
    fit = make("explained").fit.model_copy(update={**figures, "left_by_known_m": 0.01})
    rest = Unexplained(share_of_mismatch=0.0, p=1.0)
    answer = in_words(make("nothing_missing", findings=[], fit=fit, unexplained=rest))
    text = " ".join([answer.unexplained.says, fit_line(answer)])
    assert "is what the effects in the robot file usually leave" in text
    assert "within about 2.1 s err alike" in text
    assert "noise" not in text


def test_sentences_that_are_there_stay(make: Any) -> None:
    answer = make("explained")
    assert in_words(answer).findings == answer.findings


def test_a_probability_is_given_once_and_of_findings_only(parts: Any) -> None:
    play = parts["backlash"](probability=0.5)
    changes = [
        PriorSensitivity(
            effect=effect, component=play.component, probability=0.8, narrower=0.2, wider=0.96
        )
        for effect in (play.effect, "joint_compliance")
    ]
    (one,) = as_found(changes, [play])
    assert (one.effect, one.probability) == (play.effect, 0.5)
    assert (one.narrower, one.wider) == pytest.approx((0.125, 0.6))
    assert not as_found(changes, [parts["backlash"](probability=0.05)])
