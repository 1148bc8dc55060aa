"""How sure a finding is, and what else it could be: figures that agree with the answer's own."""

from __future__ import annotations

from typing import Any

import pytest

from deltactl.diagnosis.answer.records import (
    Alternative,
    Evidence,
    Finding,
    ParameterResult,
    PriorSensitivity,
    Where,
)
from deltactl.diagnosis.report.finding import how_sure, other_causes, without_line
from deltactl.diagnosis.report.headline import headline
from deltactl.diagnosis.report.remedies import remedies
from deltactl.diagnosis.report.screen import sentences_by_topic
from tests.diagnosis_report.conftest import card_text


def _finding(p: float, probability: float | None, *others: Alternative) -> Finding:
    return Finding(
        effect="following_lag", component="axis", says="", parameters={},
        where=Where(recordings=[1], axes=[], times_s=[], regime=""), alternatives=list(others),
        evidence=Evidence(delta_chi2=80.0, p=p), share_of_mismatch=0.9, probability=probability,
    )  # fmt: skip


def _other(effect: str, probability: float | None, chi2: float = 2.0) -> Alternative:
    return Alternative(effect=effect, component="axis", delta_chi2=chi2, probability=probability)


@pytest.mark.parametrize(
    ("p", "probability", "figures"),
    [
        (0.2, 0.97, ("97 % sure", "p = 0.2 ", "80 in chi-square")),
        (0.2, 0.6, ("60 % sure", "p = 0.2 ")),
        (1e-9, 0.9999, ("Above 99 % sure", "p < 1e-6 ")),
        (0.004, None, ("not computed", "p = 0.004 ")),
        (float("nan"), 0.5, ("50 % sure",)),
    ],
)
def test_one_line_has_the_probability_and_the_test_of_the_finding_alone(
    make: Any, p: float, probability: float | None, figures: tuple[str, ...]
) -> None:
    (line,) = how_sure(_finding(p, probability), make())
    assert all(figure in line for figure in figures)
    assert "nan" not in line


@pytest.mark.parametrize(("probability", "open_"), [(0.97, False), (0.7, True)])
def test_what_is_settled_has_no_alternative_in_the_headline(
    make: Any, probability: float, open_: bool
) -> None:
    one = _finding(1e-9, probability, _other("viscous_friction", None))
    answer = make("explained", findings=[one])
    assert ("(or " in headline(answer)) == open_
    assert any("1 could be" in line for line in sentences_by_topic(answer)["or_else"]) == open_


def test_what_fits_as_well_is_named_beside_a_settled_finding(make: Any) -> None:
    """A hundred to two of two causes that the readings do not tell from one another."""
    as_well, worse = _other("gear_ratio", 0.02, 0.0), _other("sensor_latency", 0.02, 9.0)
    answer = make("explained", findings=[_finding(1e-9, 0.96, as_well, worse)])
    (line,) = [one for one in sentences_by_topic(answer)["or_else"] if one.startswith("1 could be")]
    assert "ratio" in line
    assert "readings that come late" not in line
    text = card_text(answer.findings[0], answer)
    assert "(2 %; fits as well)" in text
    assert "readings that come late (2 %; 9.0 worse in chi-square)" in text


def test_alternatives_have_their_shares() -> None:
    one = _finding(1e-9, 0.55, _other("gear_backlash", 0.45))
    assert other_causes(one) == "backlash between drive and load of the axis (45 %)"


def test_causes_that_may_act_together_have_one_share_between_them() -> None:
    """Two causes that are in the same sets: 55 %, 40 % and 30 % are no shares of one whole."""
    both = _other("gear_backlash", 0.40), _other("home_offset", 0.30)
    text = other_causes(_finding(1e-9, 0.55, *both))
    assert "or a wrong home position of the axis (one or several of them: 45 %)" in text
    assert "40 %" not in text
    assert "30 %" not in text


@pytest.mark.parametrize("left_m", [0.0039, None])
def test_what_a_finding_is_worth_is_the_error_without_it(left_m: float | None) -> None:
    line = without_line(
        _finding(1e-9, 0.97).model_copy(update={"left_without_m": left_m}), "m", 0.0080
    )
    assert ("3.90 mm" in line) == (left_m is not None)
    assert bool(line) == (left_m is not None)


def test_what_one_repair_alone_would_do_is_in_percent_of_the_error() -> None:
    sizes = {"left_without_m": 0.0039, "alone_m": 0.0020, "alone_ci95_m": (0.0019, 0.0022)}
    line = without_line(_finding(1e-9, 0.97).model_copy(update=sizes), "m", 0.0080)
    assert "75 %" in line
    assert "2.00 mm [1.90 mm, 2.20 mm]" in line


def test_what_depends_on_a_prior_is_reported_with_the_finding(make: Any) -> None:
    one = _finding(1e-9, 0.99)
    hangs = PriorSensitivity(
        effect="following_lag", component="axis", probability=0.99, narrower=0.999, wider=0.18
    )
    answer = make("explained", findings=[one], prior_sensitivity=[hangs])
    assert "18 % if three times larger" in card_text(one, answer)


def test_an_alternative_that_is_more_probable_is_named_as_such(make: Any) -> None:
    """The simpler name is kept while they are nearly even, and must not sound like the answer."""
    play = Alternative(effect="gear_backlash", component="motor2", delta_chi2=3.0, probability=0.65)
    arm = play.model_copy(update={"effect": "forearm_length", "component": "arm2"})
    home = _finding(1e-9, 0.33).model_copy(
        update={
            "effect": "home_offset", "component": "motor2",
            "parameters": {"angle": ParameterResult(value=0.02, ci95=[0.01, 0.03], unit="rad")},
            "alternatives": [play, arm.model_copy(update={"probability": 0.02})],
        }
    )  # fmt: skip
    answer = make("explained", findings=[home])
    more = "or, more probably, backlash in the gear or coupling of motor 2"
    assert more in headline(answer)
    first, line, *_ = remedies(answer)
    assert "distinguish the causes" in first
    assert line.startswith("If finding 1 is confirmed, correct the home stop")
    likely = home.model_copy(update={"probability": 0.7})
    assert "more probably" not in headline(make("explained", findings=[likely]))


@pytest.mark.parametrize(("other", "rest"), [(0.02, "none of these (48 %)"), (0.5, "")])
def test_the_share_of_neither_cause_is_named(other: float, rest: str) -> None:
    tied = _finding(1e-9, 0.5, _other("viscous_friction", other))
    text = other_causes(tied)
    assert ("none of these" in text) == bool(rest)
    assert text.endswith(rest)
