"""Other tools on drawn axes: the textbook's model, what the scorer makes of it, and the table."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from benchmarks.rivals.cases import drawn, read_answers, scored, write_cases
from benchmarks.rivals.table import column, markdown
from benchmarks.rivals.tools_outside import main
from benchmarks.structure import ROOT
from deltactl.proof.axis.cases import draw

VISCOUS, HEALTHY, HEALTHY_TOO, COMMANDED = 90500055, 90500041, 90500001, 90500039
"""Seeds: an axis with effort and viscous friction alone, two with nothing, one with commands."""


@pytest.fixture(scope="module")
def said(tmp_path_factory: pytest.TempPathFactory) -> tuple[list[dict[str, Any]], Path]:
    """The truths and the textbook's answers."""
    folder = tmp_path_factory.mktemp("axes")
    truths = write_cases(
        [draw(seed) for seed in (VISCOUS, HEALTHY, HEALTHY_TOO, COMMANDED)], folder / "cases"
    )
    main("textbook", str(folder / "cases"), str(folder / "textbook.json"))
    return truths, folder / "textbook.json"


def test_the_textbook_names_and_sizes_viscous_friction(
    said: tuple[list[dict[str, Any]], Path],
) -> None:
    truths, file = said
    only = scored(truths[:1], read_answers(file))[0]
    assert only.marks.truth == only.marks.said == ["viscous_friction"]
    assert only.right
    assert only.marks.covered == [True]


def test_what_is_needless_or_claimed_of_a_healthy_axis_counts_against_a_tool(
    said: tuple[list[dict[str, Any]], Path], tmp_path: Path
) -> None:
    truths, file = said
    written = json.loads(file.read_text())
    more = {"effect": "inertia", "alternatives": [], "probability": None, "parameters": {}}
    for truth in truths[:2]:
        written["answers"][truth["case"]]["findings"].append(more)
    (tmp_path / "more.json").write_text(json.dumps(written))
    before, after = (
        column("textbook", scored(truths, read_answers(one)), 1.0)
        for one in (file, tmp_path / "more.json")
    )
    right, false = "names right, with effort", "false claims on healthy axes, with effort"
    assert (before[right][:6], after[right][:6]) == ("1 of 1", "0 of 1")
    assert (before[false][:6], after[false][:6]) == ("0 of 2", "1 of 2")


def test_what_a_tool_cannot_do_is_a_dash_with_its_reason(
    said: tuple[list[dict[str, Any]], Path],
) -> None:
    truths, file = said
    table = markdown({"textbook": column("textbook", scored(truths, read_answers(file)), 1.0)})
    assert "| names right, commanded | - |" in table
    assert "textbook: needs a column of effort" in table


def test_half_of_the_drawn_axes_are_healthy_and_none_tuned_the_diagnosis() -> None:
    cases = drawn(4, 904)
    assert [bool(case.hidden) for case in cases] == [False, True, False, True]
    assert all(case.seed % 2 for case in cases)


def test_the_other_environment_needs_nothing_of_deltactl() -> None:
    code = (
        "import sys, benchmarks.rivals.tools_outside\n"
        "sys.exit(any(name.split('.')[0] == 'deltactl' for name in sys.modules))"
    )
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True)
