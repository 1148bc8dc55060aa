"""Other tools: a case in a process of its own within a time, and two runs side by side."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from benchmarks.rivals.axis_signals import Json
from benchmarks.rivals.cases import read_answers
from benchmarks.rivals.each_case import each_case
from benchmarks.rivals.seeds import agree, main
from benchmarks.rivals.table import markdown

HITS = "names right, deltas"


def answered(case: Path) -> Json:
    """An answer that took two seconds."""
    return {"findings": [], "failure": None, "heldout": None, "seconds": 2.0, "in": os.getpid()}


def test_each_case_has_a_process_of_its_own_and_none_is_begun_after_the_time(
    tmp_path: Path,
) -> None:
    for name in "abc":
        (tmp_path / "cases" / name).mkdir(parents=True)
    answers, most_mb = each_case(answered, tmp_path / "cases", ["json"], most_s=3.0)
    assert len({os.getpid(), answers["a"]["in"], answers["b"]["in"]}) == 3
    assert most_mb > 1.0
    file = tmp_path / "said.json"
    file.write_text(json.dumps({"answers": answers, "peak_mb": most_mb}))
    read = read_answers(file)
    assert read.unbegun() == 1
    assert read.by_case["a"]["diagnosis"]["verdict"] == "nothing_missing"
    assert read.by_case["c"]["diagnosis"] is read.by_case["c"]["seconds"] is None


def test_two_runs_are_side_by_side_and_a_share_that_differs_is_marked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files = []
    for name, hits, others in (("a", 9, 5), ("b", 8, 0)):
        columns = {
            "deltactl": {HITS: f"{hits} of 9 [0.6, 1.0]", "seconds": "1.0"},
            "lmfit": {HITS: f"{others} of 5 [0.1, 0.9]"},
        }
        files.append(tmp_path / f"{name}.md")
        files[-1].write_text(f"title\n\n{markdown(columns)}")
    drawn = tmp_path / "both.svg"
    assert main([*map(str, files), "--svg", str(drawn)]) == 0
    said = capsys.readouterr().out
    assert f"|{HITS}|9/9+8/9|5/5+0/5 !|" in said
    assert "|seconds|1.0+1.0|-|" in said
    assert "1 of 2 shares differ" in said
    assert "17 of 18" in drawn.read_text()


def test_shares_of_few_cases_agree_and_of_many_do_not() -> None:
    assert agree((3, 4), (1, 4))
    assert not agree((75, 100), (25, 100))
