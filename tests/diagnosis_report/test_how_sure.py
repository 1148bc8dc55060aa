"""How sure a finding is, in words that agree with its own figures."""

from __future__ import annotations

from diagnosis.answer.records import Evidence, Finding, Where
from diagnosis.report.sentences.sureness import evidence


def _finding(p: float, probability: float) -> Finding:
    return Finding(
        effect="following_lag", component="axis", says="", parameters={},
        where=Where(recordings=[1], axes=[], times_s=[], regime=""),
        evidence=Evidence(delta_chi2=80.0, p=p), share_of_mismatch=0.9, probability=probability,
    )  # fmt: skip


def test_no_weak_evidence_beside_a_high_probability() -> None:
    said = evidence(_finding(0.2, 0.97))
    assert "Weak" not in said
    assert "Likely" in said
    assert "97 %" in said


def test_weak_evidence_is_still_called_weak() -> None:
    assert "Weak evidence" in evidence(_finding(0.2, 0.6))
