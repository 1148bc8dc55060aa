"""The gate of every change: pairs of answers, group by group."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from benchmarks.proofs import one_screen
from benchmarks.proofs.frozen_answers import Frozen, Pair, changed, paired, simulated
from deltactl.proof.cases import ROUND

CASE = Frozen("case", "single", None, Path(), Path(), Path(), None)
TRUTH = {
    "case": "case", "group": "practice", "motion": "survey",
    "answers": [{"effect": "payload", "where": "platform"}],
}  # fmt: skip


def kept(*effects: str, **more: Any) -> dict[str, Any]:
    findings = [{"effect": effect, "component": "platform"} for effect in effects]
    return {"answer": {"findings": findings, **more}, "failure": None}


def pairs(lost: int, won: int) -> list[Pair]:
    right, wrong = kept("payload"), kept("contact")
    return [
        *[Pair(CASE, TRUTH, right, wrong)] * lost,
        *[Pair(CASE, TRUTH, wrong, right)] * won,
        *[Pair(CASE, TRUTH, right, right)] * 5,
    ]


@pytest.mark.parametrize(("lost", "won", "p"), [(0, 0, 1.0), (1, 1, 1.0), (6, 0, 2.0 / 2**6)])
def test_pairs_that_changed_one_way_are_counted(lost: int, won: int, p: float) -> None:
    row = paired(pairs(lost, won))
    assert (row.lost, row.won, row.same) == (lost, won, 5)
    assert (row.old_right, row.new_right) == (5 + lost, 5 + won)
    assert row.p == pytest.approx(p)


def test_a_refusal_is_no_right_answer() -> None:
    refused = {"answer": None, "failure": "RecordingError: too short"}
    assert paired([Pair(CASE, TRUTH, kept("payload"), refused)]).lost == 1


def test_what_changed_is_named_by_its_place() -> None:
    old = kept("payload", fit={"rms_m": 1.0}, robot="a")["answer"]
    new = kept("contact", fit={"rms_m": 2.0}, robot="b", probability=None)["answer"]
    assert changed(old, new) == [".findings[0].effect", ".fit.rms_m"]
    assert changed(old, kept(fit={"rms_m": 1.0})["answer"]) == [".findings"]


def test_a_tenth_has_every_group(tmp_path: Path) -> None:
    tenth = list(simulated(tmp_path, [1, 2], 300, tenth=True))
    assert len(tenth) == 60
    assert {case.group for case in tenth} == set(ROUND)


@pytest.mark.study
def test_an_answer_beyond_the_screen_is_counted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """One that fits, and the same on a screen of fewer lines and columns than it takes."""
    words = ["--keep", str(tmp_path), "--axes", "1", "--arms", "0", "--deltas", "0"]
    assert one_screen.main(words) == 0
    (row,) = [line for line in capsys.readouterr().out.splitlines() if line.startswith("axis, ")]
    lines, columns, beyond = map(int, row.split()[-3:])
    assert (lines > 0, columns > 0, beyond) == (True, True, 0)
    for name, most in (("LINES", lines - 1), ("WIDTH", columns - 1)):
        with monkeypatch.context() as patch:
            patch.setattr(one_screen, name, most)
            assert one_screen.main(words) == 1
