"""Whatever the engine hands over, the answer agrees with itself."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.proofs.contradictions import contradictions
from deltactl.diagnosis.answer.assembly import assembled, sharing
from deltactl.diagnosis.answer.options import VERDICT
from deltactl.diagnosis.answer.records import (
    Alternative,
    Diagnosis,
    Evidence,
    Finding,
    Fit,
    ParameterResult,
    Unexplained,
    Where,
)
from deltactl.diagnosis.answer.verdict import ALARM, Rest, claimed, left_over, rather_unknown

RMS = st.floats(1e-6, 1.0)
PS = st.one_of(st.floats(0.0, 1.0), st.sampled_from([0.0, 1e-300, ALARM, 1.0]))
SHARES = st.floats(0.0, 1.0)


def finding(effect: str = "gear_backlash", share: float = 0.5, **sizes: ParameterResult) -> Finding:
    return Finding(
        effect=effect,
        component="motor1",
        says="",
        parameters=sizes or {"width": ParameterResult(value=0.01, ci95=[0.009, 0.011], unit="rad")},
        where=Where(axes=["range_x"], times_s=[(0.0, 1.0)], regime="everywhere"),
        evidence=Evidence(delta_chi2=100.0, p=1e-9),
        share_of_mismatch=share,
    )


FINDINGS = st.lists(
    st.builds(finding, st.sampled_from(["gear_backlash", "unknown", "home_offset"]), SHARES),
    max_size=4,
)
FITS = st.builds(
    lambda before, after, floor, held_before, held_after: Fit(
        rms_before_m=before, rms_after_m=after, noise_floor_m=floor,
        holdout_rms_before_m=held_before, holdout_rms_after_m=held_after,
    ),
    RMS, RMS, RMS, RMS, RMS,
)  # fmt: skip
RESTS = st.builds(
    Rest, PS, st.sampled_from([("theta_1",), ("time", "range_x")]), st.just("motor1"),
    st.floats(1e-9, 1.0),
)  # fmt: skip


@given(FINDINGS, FITS, PS, RESTS, st.none() | st.floats(0.0, 1.0))
def test_no_answer_contradicts_itself(
    findings: list[Finding], fit: Fit, p: float, rest: Rest, nothing: float | None
) -> None:
    answer = assembled(findings, fit, p, rest, nothing)
    assert contradictions(answer) == []
    assert Diagnosis.model_validate(answer.to_json()).verdict == answer.verdict


def sound(**changes: Any) -> Diagnosis:
    fit = Fit(
        rms_before_m=5.0, rms_after_m=1.0, noise_floor_m=1.0, holdout_rms_before_m=5.0,
        holdout_rms_after_m=1.1,
    )  # fmt: skip
    answer = assembled([finding(share=0.9)], fit, 1e-9, Rest(0.5, share=0.0))
    assert contradictions(answer) == []
    assert answer.verdict == "explained"
    return answer.model_copy(update=changes)


def fit_of(**changes: float) -> Fit:
    return sound().fit.model_copy(update=changes)


def likely(probability: float) -> Finding:
    return finding().model_copy(update={"probability": probability})


def left(share: float, *depends_on: str) -> Unexplained:
    return Unexplained(share_of_mismatch=share, depends_on=list(depends_on))


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"verdict": "nothing_missing"}, "there are findings"),
        ({"verdict": "nothing_missing", "findings": []}, "with p = 1e-09"),
        ({"verdict": "unexplained"}, "a named effect is a finding"),
        ({"findings": [finding("unknown")]}, "not by named effects alone"),
        ({"findings": [finding(), finding("unknown", 0.4)]}, "not by named effects alone"),
        ({"verdict": "partly_explained", "findings": []}, "nothing that has a name"),
        ({"fit": fit_of(rms_after_m=1.01 * VERDICT.at_floor)}, "above the noise floor"),
        ({"fit": fit_of(holdout_rms_after_m=5.01 * VERDICT.grew)}, "held-out model error grew"),
        ({"findings": [finding(share=0.6), finding(share=0.6)]}, "add up to 1.2"),
        ({"findings": [finding(share=0.6)], "unexplained": left(0.6)}, "add up to 1.2"),
        ({"unexplained": left(0.0, "time")}, "the residual is not above the noise floor"),
        ({"unexplained": left(0.1)}, "the residual is not above the noise floor"),
        ({"probability_nothing_missing": 1.2}, "between 0 and 1"),
        ({"probability_nothing_missing": 0.6, "findings": [likely(0.6)]}, "more than certain"),
        ({"says": ["Nothing is missing in the model."]}, "the verdict does not"),
    ],
)
def test_a_contradiction_is_seen(changes: dict[str, Any], says: str) -> None:
    assert any(says in line for line in contradictions(sound(**changes)))


@pytest.mark.parametrize(
    ("effect", "name", "value", "ci95", "says"),
    [
        ("lost_steps", "steps", 0.42, [0.3, 0.5], "less than one step"),
        ("home_offset", "angle", 0.1, [0.1, 0.1], "no width"),
        ("following_lag", "dead_time", 2.0, [0.65, 2.0], "at its bound"),
        ("gear_backlash", "width", 0.0, [0.0, 0.1], "no size"),
        ("home_offset", "angle", 0.1, [0.2, 0.3], "outside its interval"),
    ],
)
def test_a_size_that_cannot_be_is_seen(
    effect: str, name: str, value: float, ci95: list[float], says: str
) -> None:
    one = finding(effect, **{name: ParameterResult(value=value, ci95=ci95, unit="rad")})
    assert any(says in line for line in contradictions(sound(findings=[one])))


@pytest.mark.parametrize("endless", [1e300, float("inf")])
def test_what_does_not_exist_is_null(endless: float) -> None:
    stiff = ParameterResult(value=endless, ci95=[1000.0, endless], unit="N m/rad")
    assert stiff.model_dump(mode="json") == {
        "value": None, "ci95": [1000.0, None], "unit": "N m/rad",
    }  # fmt: skip
    assert contradictions(sound(findings=[finding(stiffness=stiff)])) == []


@pytest.mark.parametrize(
    ("p", "left_p", "after", "said"),
    [
        (1.01 * ALARM, 1.01 * ALARM, 1.0, "nothing_missing"),
        (0.99 * ALARM, 1.0, 1.0, "unexplained"),
        (1.0, 0.99 * ALARM, 1.0, "unexplained"),
        (1.0, 1.0, 12.0, "unexplained"),
    ],
)
def test_one_level_decides_whether_anything_is_missing(
    p: float, left_p: float, after: float, said: str
) -> None:
    """Without a finding: the alarm, the residual by the same level, and its size."""
    fit = Fit(
        rms_before_m=after, rms_after_m=after, noise_floor_m=1.0,
        holdout_rms_before_m=after, holdout_rms_after_m=after,
    )  # fmt: skip
    assert assembled([], fit, p, Rest(left_p)).verdict == said


def test_a_fit_below_the_floor_lowers_the_floor() -> None:
    low = fit_of(rms_after_m=0.8)
    assert assembled([finding()], low, 0.0, Rest(0.5, share=0.0)).fit.noise_floor_m == 0.8
    more = assembled([finding()], low, 0.0, Rest(1e-9, ("time",), "motor1", 0.19))
    assert more.fit.noise_floor_m == pytest.approx(0.72)
    assert more.verdict == "partly_explained" or more.unexplained.share_of_mismatch < 0.05


@pytest.mark.parametrize(
    ("effect", "after", "said"),
    [
        ("gear_backlash", 4.9, "explained"),
        ("gear_backlash", 5.0, "partly_explained"),
        ("lost_steps", 5.0, "explained"),
        ("contact", 5.0, "explained"),
        ("lost_steps", 5.0 * VERDICT.grew + 0.01, "partly_explained"),
    ],
)
def test_an_effect_that_brings_no_held_out_gain_explains_nothing(
    effect: str, after: float, said: str
) -> None:
    """An event does not come back on held-out data, and not each run touches the table: they need
    only do no harm there.
    """
    fit = Fit(
        rms_before_m=5.0, rms_after_m=1.0, noise_floor_m=1.0, holdout_rms_before_m=5.0,
        holdout_rms_after_m=after,
    )  # fmt: skip
    assert assembled([finding(effect)], fit, 1e-9, Rest(0.5)).verdict == said


def test_an_event_explains_where_no_reading_is_left_for_the_held_out_figure() -> None:
    fit = fit_of(holdout_rms_before_m=0.0, holdout_rms_after_m=0.0)
    assert assembled([finding("lost_steps")], fit, 1e-9, Rest(0.5)).verdict == "explained"


@pytest.mark.parametrize(("left_p", "said"), [(0.5, "explained"), (0.0, "partly_explained")])
def test_what_a_test_still_sees_is_not_explained_when_it_is_much_of_the_mismatch(
    left_p: float, said: str
) -> None:
    """A residual at the floor, and a sixth of the little that was missing is still there."""
    fit = fit_of(rms_before_m=1.3, rms_after_m=1.05)
    assert assembled([finding()], fit, 1e-9, Rest(left_p)).verdict == said


def test_findings_that_explain_nothing_have_a_share_of_nothing() -> None:
    assert [one.share_of_mismatch for one in sharing([finding(share=0.0)], 0.0)] == [0.0]


@pytest.mark.parametrize("unit_m", [1.0, 1e-3])
@pytest.mark.parametrize(("after", "left"), [(1.0, 0.0), (2.0, 0.125), (5.0, 1.0), (7.0, 1.0)])
def test_what_is_left_is_a_share_of_the_power_above_the_noise(
    after: float, left: float, unit_m: float
) -> None:
    fit = Fit(
        rms_before_m=5.0 * unit_m, rms_after_m=after * unit_m, noise_floor_m=unit_m,
        holdout_rms_before_m=5.0 * unit_m, holdout_rms_after_m=after * unit_m,
    )  # fmt: skip
    assert left_over(fit, Rest(0.0)) == pytest.approx(left)


def test_what_is_left_over_of_noise_is_nothing() -> None:
    above = fit_of(rms_after_m=0.5 + 0.5 * VERDICT.at_floor)  # and yet at the floor
    assert left_over(above, Rest(0.5)) == 0.0
    assert left_over(above, Rest(0.0)) > 0.0


@pytest.mark.parametrize(("beside", "effect", "unknown"), [
    (0.9, "unknown", True),
    (0.1, "unknown", False),
    (0.9, "home_offset", False),
])  # fmt: skip
def test_a_name_is_doubted_for_something_unknown_and_for_no_other_name(
    beside: float, effect: str, unknown: bool
) -> None:
    other = Alternative(effect=effect, component="motor1", delta_chi2=1.0, probability=beside)
    named = likely(0.09).model_copy(update={"alternatives": [other]})
    assert rather_unknown(named) is unknown
    assert claimed(named) is not unknown
