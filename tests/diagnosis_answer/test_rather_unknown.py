"""A name that is more probably a part of something unknown is not claimed in any sentence."""

from __future__ import annotations

from benchmarks.proofs.contradictions import contradictions
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
from deltactl.diagnosis.answer.verdict import Rest, verdict
from deltactl.diagnosis.report.headline import headline
from deltactl.diagnosis.report.in_words import in_words
from deltactl.diagnosis.report.screen import sentences

FIT = Fit(
    rms_before_m=2e-3, rms_after_m=1.5e-3, noise_floor_m=1.5e-3,
    holdout_rms_before_m=2e-3, holdout_rms_after_m=1.5e-3,
)  # fmt: skip
WHERE = Where(axes=["range_x"], times_s=[(0.0, 10.0)], recordings=[1])


def finding(effect: str, probability: float, *alternatives: Alternative) -> Finding:
    name, unit = ("size_rms", "rad") if effect == "unknown" else ("width", "rad")
    return Finding(
        effect=effect, component="motor1", where=WHERE, probability=probability,
        parameters={name: ParameterResult(value=0.002, ci95=[0.001, 0.003], unit=unit)},
        evidence=Evidence(delta_chi2=150.0, p=1e-30), share_of_mismatch=0.4,
        alternatives=list(alternatives), depends_on=["theta_1"] if effect == "unknown" else [],
    )  # fmt: skip


def answer(own: float) -> Diagnosis:
    other = Alternative(
        effect="unknown", component="motor1", delta_chi2=150.0, probability=0.98 - own
    )
    found = [finding("unknown", 0.98), finding("gear_backlash", own, other)]
    return in_words(
        Diagnosis(
            robot="r", recordings=["a.csv"], fit=FIT, findings=found, false_alarm_p=1e-9,
            probability_nothing_missing=0.0, unexplained=Unexplained(share_of_mismatch=0.0),
            verdict=verdict(found, FIT, 1e-9, Rest(1.0), 0.0),
        )
    )  # fmt: skip


def test_an_improbable_name_is_in_no_headline_and_asks_for_no_work() -> None:
    said = answer(0.05)
    assert said.verdict == "unexplained"
    assert "backlash" not in headline(said)
    assert not any("take up the play" in line.lower() for line in sentences(said))
    assert any("Probably only a part of what is unknown" in line for line in sentences(said))
    assert contradictions(said) == []


def test_a_probable_one_is_named_as_before() -> None:
    said = answer(0.6)
    assert said.verdict == "partly_explained"
    assert "backlash" in headline(said)
    assert any("take up the play" in line.lower() for line in sentences(said))
    assert contradictions(said) == []
