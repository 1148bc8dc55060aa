"""How sure a finding is, in words that agree with its own figures."""

from __future__ import annotations

from typing import Any

import pytest

from deltactl.diagnosis.answer.records import Alternative, Evidence, Finding, ParameterResult, Where
from deltactl.diagnosis.report.finding import alternatives_line, evidence, in_chi_square
from deltactl.diagnosis.report.fit import share_line
from deltactl.diagnosis.report.headline import headline
from deltactl.diagnosis.report.remedies import remedies


def _finding(p: float, probability: float) -> Finding:
    return Finding(
        effect="following_lag", component="axis", says="", parameters={},
        where=Where(recordings=[1], axes=[], times_s=[], regime=""),
        evidence=Evidence(delta_chi2=80.0, p=p), share_of_mismatch=0.9, probability=probability,
    )  # fmt: skip


def test_no_weak_evidence_beside_a_high_probability() -> None:
    said = evidence(_finding(0.2, 0.97))
    assert "Weak" not in said
    assert said.startswith("97 % sure that this is the cause.")


def test_weak_evidence_is_still_called_weak() -> None:
    assert "Weak evidence" in evidence(_finding(0.2, 0.6))


def test_what_is_surely_one_of_two_is_not_weak_because_it_may_be_either() -> None:
    play = Alternative(effect="gear_backlash", component="axis", delta_chi2=0.0, probability=0.46)
    one = _finding(0.2, 0.53).model_copy(update={"alternatives": [play]})
    said = evidence(one)
    assert said.startswith("99 % sure that it is this (53 %) or ")
    assert said.endswith("(46 %); no single test shows it.")
    assert alternatives_line(one) == "", "the two are named once"
    less = play.model_copy(update={"probability": 0.1})
    assert "Weak evidence" in evidence(one.model_copy(update={"alternatives": [less]}))


@pytest.mark.parametrize(("probability", "open_"), [(0.97, False), (0.7, True)])
def test_what_is_settled_has_no_rival_in_the_headline(
    make: Any, probability: float, open_: bool
) -> None:
    other_cause = Alternative(effect="viscous_friction", component="axis", delta_chi2=2.0)
    one = _finding(1e-9, probability).model_copy(update={"alternatives": [other_cause]})
    assert ("(or " in headline(make("explained", findings=[one]))) == open_
    assert ("this recording cannot tell" in evidence(one)) == open_
    assert alternatives_line(one).startswith("" if open_ else "Far less probable: ")


def test_what_fits_as_well_is_rarer_and_not_denied_by_the_readings() -> None:
    """98 % that are what is usual, and beside them: far less probable, fits as well."""
    ratio = Alternative(effect="gear_ratio", component="axis", delta_chi2=0.0, probability=0.02)
    late = ratio.model_copy(update={"effect": "sensor_latency", "delta_chi2": 9.0})
    settled = _finding(1e-9, 0.96).model_copy(update={"alternatives": [ratio, late]})
    said = alternatives_line(settled)
    assert "of the axis would fit these readings as well, but is rarer (2 %)." in said
    assert said.endswith("Far less probable: readings that come late (2 %).")
    alone = settled.model_copy(update={"alternatives": [ratio]})
    assert "Far less" not in alternatives_line(alone)
    tied = settled.model_copy(update={"alternatives": [ratio], "probability": 0.8})
    assert evidence(tied).endswith(": both fit it as well, and the shares only say how usual each"
                                   " is.")  # fmt: skip
    assert "usual" not in evidence(tied.model_copy(update={"alternatives": [late]}))


def _friction(own: float, *others: float) -> Finding:
    other_causes = [
        Alternative(effect=effect, component="axis", delta_chi2=2.0, probability=probability)
        for effect, probability in zip(("gear_backlash", "home_offset"), others, strict=False)
    ]
    update = {"effect": "joint_friction", "alternatives": other_causes}
    return _finding(1e-9, own).model_copy(update=update)


def test_a_finding_and_what_it_may_be_instead_are_told_once_and_add_up() -> None:
    said = evidence(_friction(0.55, 0.45))
    assert said == (
        "Something is there beyond doubt; whether it is this (55 %) or backlash between drive and"
        " load of the axis (45 %), this recording cannot tell."
    )
    assert alternatives_line(_friction(0.55, 0.45)) == ""


def test_causes_that_may_act_together_have_one_share_between_them() -> None:
    """Two causes that are in the same sets: 55 %, 40 % and 30 % are no shares of one whole."""
    said = evidence(_friction(0.55, 0.40, 0.30))
    assert "or a wrong home position of the axis (one or several of them: 45 %)" in said
    assert "40 %" not in said
    assert "30 %" not in said


def test_odds_of_a_single_test_do_not_stand_beside_a_probability() -> None:
    """Beyond doubt in one answer and 1 in 56 in the next, of the same cause, 98 % sure in both."""
    for p in (1e-9, 1.0 / 56.0):
        assert evidence(_finding(p, 0.98)) == "98 % sure that this is the cause."
        assert "its own test: noise alone" in in_chi_square(_finding(p, 0.98), explained=False)


def test_rivals_below_one_percent_are_listed_once() -> None:
    other_causes = [
        Alternative(effect=effect, component="axis", delta_chi2=2.0, probability=probability)
        for effect, probability in
        [("viscous_friction", 0.02), ("gear_backlash", 0.001), ("following_lag", 1e-6)]
    ]  # fmt: skip
    settled = _finding(1e-9, 0.97)
    said = alternatives_line(settled.model_copy(update={"alternatives": other_causes}))
    assert said.count("below 1 %") == 1
    assert "(2 %)" in said
    assert said.endswith("(below 1 % each).")
    one = alternatives_line(settled.model_copy(update={"alternatives": other_causes[:2]}))
    assert one.endswith("(below 1 %).")


@pytest.mark.parametrize(("p", "said"), [(1e-9, True), (0.2, False)])
def test_a_small_part_beside_a_sure_finding_is_no_contradiction(
    make: Any, p: float, said: bool
) -> None:
    finding = _finding(p, 0.97).model_copy(update={"share_of_mismatch": 0.004})
    line = share_line(finding, make().fit)
    assert "its part is small" in line.lower()
    assert ("but more than noise" in line) == said


@pytest.mark.parametrize(
    ("share", "left_m", "said"),
    [
        (0.9, 0.0039, "Without it the error would be 3.90 instead of 2.21 mm."),
        (0.1, 0.0025, "If it alone were left out, the error would be 2.50 instead of 2.21 mm:"),
        (0.9, None, "Without it the error would be about 3.95 instead of 2.21 mm."),
        (0.004, 0.00221, "without it the error would be about the same."),
        (
            0.004,
            0.0019,
            "without it the error as a whole would be no larger, yet what tells most would fit"
            " worse.",
        ),
        (0.9, 0.0555, "Without it the error would be 55.5 instead of 2.21 mm."),
    ],
)
def test_what_a_finding_does_is_told_in_the_unit_of_the_mismatch(
    make: Any, share: float, left_m: float | None, said: str
) -> None:
    """A share of the power beside figures that are root mean squares reads as a contradiction."""
    changes = {"share_of_mismatch": share, "left_without_m": left_m}
    fit = make().fit.model_copy(update={"noise_floor_m": 0.001})
    line = share_line(_finding(1e-9, 0.97).model_copy(update=changes), fit)
    assert said in line
    assert "%" not in line


def test_beside_much_noise_what_a_finding_does_is_told_beyond_the_noise(make: Any) -> None:
    """2.50 instead of 2.21 mm seems to be little, and is eight tenths of what is not noise."""
    changes = {"share_of_mismatch": 0.1, "left_without_m": 0.0025}
    line = share_line(_finding(1e-9, 0.97).model_copy(update=changes), make().fit)
    assert "the error beyond the noise would be 1.36 instead of 0.689 mm" in line


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
    first, line = remedies(answer)
    assert "tell the causes apart" in first
    assert line.startswith("If finding 1 is confirmed, correct the home stop")
    likely = home.model_copy(update={"probability": 0.7})
    assert "more probably" not in headline(make("explained", findings=[likely]))
