"""What is left and goes on between readings is no sensor's noise, whatever the tests say."""

from __future__ import annotations

import pytest

from deltactl.diagnosis.answer.records import (
    Diagnosis,
    Evidence,
    Finding,
    Fit,
    ParameterResult,
    Unexplained,
    Verdict,
    Where,
)
from deltactl.diagnosis.answer.verdict import Rest, verdict
from deltactl.diagnosis.report.headline import headline
from deltactl.diagnosis.report.remedies import remedies
from deltactl.diagnosis.report.templates import say

LAG = Finding(
    effect="following_lag", component="motor1",
    where=Where(axes=["position"], times_s=[(0.0, 10.0)], recordings=[1]), probability=0.99,
    parameters={"time": ParameterResult(value=0.09, ci95=[0.08, 0.1], unit="s")},
    evidence=Evidence(delta_chi2=150.0, p=1e-30), share_of_mismatch=0.7, alternatives=[],
)  # fmt: skip


@pytest.mark.parametrize(
    ("left_m", "correlation", "said"),
    [
        (5e-3, 0.1, "explained"),
        (5e-3, 0.95, "partly_explained"),
        (5e-3, None, "explained"),
        (1e-3, 0.95, "explained"),
    ],
    ids=["white", "goes on", "not known", "goes on and is faint"],
)
def test_the_model_explains_no_more_than_it_does(
    left_m: float, correlation: float | None, said: Verdict
) -> None:
    fit = Fit(
        rms_before_m=0.01, rms_after_m=left_m, noise_floor_m=left_m, holdout_rms_before_m=0.01,
        holdout_rms_after_m=left_m, left_correlation=correlation,
    )  # fmt: skip
    assert verdict([LAG], fit, 1e-9, Rest(1.0), 0.0) == said


def test_a_fit_that_grows_asks_for_no_work() -> None:
    worse = Fit(
        rms_before_m=0.010, rms_after_m=0.012, noise_floor_m=0.012, holdout_rms_before_m=0.01,
        holdout_rms_after_m=0.012,
    )  # fmt: skip
    answer = Diagnosis(
        robot="r", recordings=["a.csv"], fit=worse, findings=[LAG], false_alarm_p=1e-9,
        probability_nothing_missing=0.0, unexplained=Unexplained(share_of_mismatch=0.0),
        verdict=verdict([LAG], worse, 1e-9, Rest(1.0), 0.0),
    )  # fmt: skip
    assert answer.verdict == "partly_explained"
    assert remedies(answer) == [say("do.change_nothing")]
    assert "no better" in headline(answer)
    better = worse.model_copy(update={"rms_after_m": 0.005})
    assert remedies(answer.model_copy(update={"fit": better})) != [say("do.change_nothing")]
