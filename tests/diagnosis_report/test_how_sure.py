"""How sure a finding is, in words that agree with its own figures."""

from __future__ import annotations

from typing import Any

import pytest

from diagnosis.answer.records import Alternative, Evidence, Finding, Where
from diagnosis.report.sentences.summary import alternatives_line, headline
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


@pytest.mark.parametrize(("probability", "open_"), [(0.97, False), (0.7, True)])
def test_what_is_settled_has_no_rival_in_the_headline(
    make: Any, probability: float, open_: bool
) -> None:
    rival = Alternative(effect="viscous_friction", component="axis", delta_chi2=2.0)
    one = _finding(1e-9, probability).model_copy(update={"alternatives": [rival]})
    assert ("(or " in headline(make("explained", findings=[one]))) == open_
    assert alternatives_line(one).startswith(
        "This recording cannot tell" if open_ else "Far less probable: "
    )
