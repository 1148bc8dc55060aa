"""Other tools on drawn axes: the textbook's model, what the scorer makes of it, and the table."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from benchmarks.rivals.cases import (
    Scored,
    cut_in_halves,
    drawn,
    read_answers,
    scored,
    write_cases,
)
from benchmarks.rivals.picture import drawing
from benchmarks.rivals.real import judged, write_real
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


@pytest.mark.study
def test_the_textbook_names_and_sizes_viscous_friction(
    said: tuple[list[dict[str, Any]], Path],
) -> None:
    truths, file = said
    only = scored(truths[:1], read_answers(file))[0]
    assert only.truth == only.said == ["viscous_friction"]
    assert only.right
    assert only.sizes == [True]


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
    right, false = "names right, with effort", "false claims on healthy machines, with effort"
    assert (before[right][:6], after[right][:6]) == ("1 of 1", "0 of 1")
    assert (before[false][:6], after[false][:6]) == ("0 of 2", "1 of 2")


def test_what_a_tool_cannot_do_is_a_dash_with_its_reason(
    said: tuple[list[dict[str, Any]], Path],
) -> None:
    truths, file = said
    table = markdown({"textbook": column("textbook", scored(truths, read_answers(file)), 1.0)})
    assert "| 95 % intervals that hold, commanded |" not in table
    with_another = markdown(
        {"textbook": column("textbook", scored(truths, read_answers(file)), 1.0),
         "lmfit": {"names right, commanded": "1 of 1"}}
    )  # fmt: skip
    assert "| names right, commanded | - | 1 of 1 |" in with_another
    assert "textbook: needs a column of effort" in with_another


@pytest.mark.study
def test_two_halves_of_a_recording_agree_on_a_size_or_are_counted(tmp_path: Path) -> None:
    truths = write_cases([draw(VISCOUS)], tmp_path / "cases")
    cut_in_halves(tmp_path / "cases")
    main("textbook", str(tmp_path / "cases"), str(tmp_path / "said.json"))
    assert scored(truths, read_answers(tmp_path / "said.json"))[0].agree == [True]
    written = json.loads((tmp_path / "said.json").read_text())
    half = written["answers"][truths[0]["case"] + ".second"]["findings"][0]
    size = half["parameters"]["coefficient"]
    half["parameters"]["coefficient"] = {
        "value": 2.0 * size["value"], "ci95": [2.0 * end for end in size["ci95"]]
    }  # fmt: skip
    (tmp_path / "apart.json").write_text(json.dumps(written))
    assert scored(truths, read_answers(tmp_path / "apart.json"))[0].agree == [False]


def test_errors_of_sizes_are_held_against_the_least_that_noise_allows(
    said: tuple[list[dict[str, Any]], Path],
) -> None:
    truths, file = said
    (over,) = scored(truths[:1], read_answers(file))[0].over_bound
    assert 0.0 < over < 10.0


@pytest.fixture
def given(tmp_path: Path) -> tuple[Path, float]:
    """A folder as of real recordings, and the viscous friction in it."""
    truth = write_cases([draw(VISCOUS)], tmp_path / "drawn")[0]
    machine = tmp_path / "given" / "machine"
    (tmp_path / "given").mkdir()
    shutil.move(tmp_path / "drawn" / truth["case"], machine)
    return machine, truth["answers"][0]["values"]["coefficient"]


def _judged(machine: Path, expected: dict[str, Any]) -> Scored:
    answer = {"expected": [], "holdout": "holdout.csv.gz", "rms_with_effect": 1.0} | expected
    text = json.dumps({"_about": {}, "recording.csv.gz": answer})
    (machine / "expected.json").write_text(text)
    shutil.rmtree(machine.parents[1] / "cases", ignore_errors=True)
    known, skipped = write_real(machine.parent, machine.parents[1] / "cases")
    assert not skipped
    main("textbook", str(machine.parents[1] / "cases"), str(machine.parents[1] / "said.json"))
    return judged(known, read_answers(machine.parents[1] / "said.json"))[0]


@pytest.mark.study
def test_a_real_recording_is_right_by_its_names_and_the_ranges_of_its_sizes(
    given: tuple[Path, float],
) -> None:
    machine, size = given
    viscous = {"effect": "viscous_friction", "component": "motor1", "parameter": "coefficient"}
    inside = _judged(machine, {"expected": [viscous | {"range": [0.8 * size, 1.2 * size]}]})
    assert (inside.right, inside.sizes, inside.false) == (True, [True], False)
    outside = _judged(machine, {"expected": [viscous | {"range": [2.0 * size, 3.0 * size]}]})
    assert (outside.right, outside.sizes) == (False, [False])
    missed = _judged(machine, {"expected": [{"effect": "joint_friction", "component": "axis"}]})
    assert (missed.right, missed.sizes) == (False, [])


@pytest.mark.study
def test_what_must_not_be_claimed_of_a_real_machine_is_a_false_claim(
    given: tuple[Path, float],
) -> None:
    machine, _ = given
    assert _judged(machine, {"must_not_claim": ["viscous_friction"]}).false
    assert _judged(machine, {"must_not_claim": ["viscous_friction as the main effect"]}).false
    assert not _judged(machine, {"must_not_claim": ["inertia", "gear_backlash over 1 m"]}).false


def test_real_recordings_that_cannot_be_used_are_left_out_with_a_reason(tmp_path: Path) -> None:
    known, skipped = write_real(tmp_path / "absent", tmp_path / "cases")
    assert known == []
    assert "absent" in skipped[0]
    (tmp_path / "given" / "robot").mkdir(parents=True)
    (tmp_path / "given" / "robot" / "robot.yaml").write_text("kind: delta\nname: other\n")
    (tmp_path / "given" / "robot" / "expected.json").write_text("{}")
    assert "kind delta" in write_real(tmp_path / "given", tmp_path / "cases")[1][0]


def test_the_drawing_shows_every_share_once_for_each_tool_that_has_it() -> None:
    table = {
        "deltactl": {"names right, deltas": "3 of 4 [0.30, 0.95]", "seconds, median": "1.00"},
        "lmfit": {
            "names right, deltas": "1 of 4 [0.05, 0.70]",
            "95 % intervals": "2 of 2 [0.3, 1]",
        },
        "PySINDy": {"names right, deltas": "-"},
    }
    whole, brief = (ElementTree.fromstring(drawing([table], small)) for small in (False, True))
    mark = "{http://www.w3.org/2000/svg}circle"
    assert len(whole.findall(mark)) == 3
    assert len(brief.findall(mark)) == 2


def test_half_of_the_drawn_axes_are_healthy_and_none_tuned_the_diagnosis() -> None:
    cases = drawn(4, 904)
    assert [bool(case.hidden) for case in cases] == [False, True, False, True]
    assert all(case.seed % 2 for case in cases)


@pytest.mark.study
def test_the_other_environment_needs_nothing_of_deltactl() -> None:
    code = (
        "import sys, benchmarks.rivals.tools_outside\n"
        "sys.exit(any(name.split('.')[0] == 'deltactl' for name in sys.modules))"
    )
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True)
