"""Texts say sizes in the fine unit in which a table was recorded; numbers of JSON are in SI."""

from __future__ import annotations

import json
import re
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from deltactl.diagnosis.api import diagnose_recordings
from deltactl.diagnosis.report.headline import headline
from deltactl.diagnosis.report.sizes import scale_of
from deltactl.models.effects.units_in_use import FINE, said, said_in
from deltactl.models.robot_files import load_with_effects
from deltactl.recording.foreign.mapping import load_mapping
from deltactl.recording.foreign.reading import read_mapped
from deltactl.recording.foreign.units import IN_SI

Deltactl = Callable[..., subprocess.CompletedProcess[str]]
T_S = 0.05 * np.arange(1200)
ASKED = np.sin(0.31 * T_S) + 0.4 * np.sin(0.86 * T_S)


@pytest.mark.parametrize("unit", FINE)
def test_a_fine_unit_of_a_table_is_that_of_its_answers(unit: str) -> None:
    base, word, many = FINE[unit]
    assert many * IN_SI[unit] == pytest.approx(1.0)
    with said_in(["s", unit]):
        assert said(2.5 * IN_SI[unit], base) == f"2.50 {word}"
        assert scale_of(f"{base}/s").unit == f"{word}/s"
    assert word not in said(2.5 * IN_SI[unit], base)


@pytest.mark.parametrize("unit", ["rad", "turn", "deg", "1"])
def test_others_are_said_in_degrees(unit: str) -> None:
    with said_in([unit]):
        assert said(0.1, "rad") == "5.73 degrees"


@pytest.mark.study
@pytest.mark.parametrize(
    ("unit", "motion", "word"),
    [("arcsec", "rotary", "arcsec"), ("mrad", "rotary", "mrad"), ("um", "linear", "\u00b5m")],
)
def test_an_answer_is_in_the_unit_of_the_columns(
    deltactl: Deltactl, tmp_path: Path, unit: str, motion: str, word: str
) -> None:
    noise = 0.02 * np.random.default_rng(2).standard_normal(len(T_S))
    cells = np.stack([T_S, 900.0 * ASKED, 903.6 * ASKED + 2.5 + noise], axis=1)
    head = f"t,cmd_{unit},enc_{unit}"
    np.savetxt(tmp_path / "log.csv", cells, "%.5f", ",", header=head, comments="")
    described = f"kind: servo_axis\nname: a\nmotion: {motion}\nzero: absolute\n"
    (tmp_path / "a.yaml").write_text(described)
    columns = ("--set", f"command=cmd_{unit}", "--set", f"position=enc_{unit}")
    files = ("--json", "a.json", "--report", "a.html")
    done = deltactl("diagnose", "log.csv", "--robot", "a.yaml", *columns, *files)
    size_shown = re.compile(rf"\+2\.(49|50)\d* {word}")
    assert size_shown.search(done.stdout)
    assert "degrees" not in done.stdout
    answer = json.loads((tmp_path / "a.json").read_text())
    assert answer["units"]["position"] == unit
    parts = [part for one in answer["findings"] for part in one["parameters"].values()]
    assert pytest.approx(2.5 * IN_SI[unit], rel=0.01) in [part["value"] for part in parts]
    assert size_shown.search(" ".join(answer["says"]))
    assert size_shown.search((tmp_path / "a.html").read_text())
    read = read_mapped(tmp_path / "log.csv", load_mapping(None, columns[1::2]))
    whole = diagnose_recordings(load_with_effects(tmp_path / "a.yaml"), [read])
    assert size_shown.search(headline(whole) + " ".join(whole.says))
    assert word in headline(whole, brief=True)
