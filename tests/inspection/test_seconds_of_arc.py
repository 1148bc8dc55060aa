"""Angles in seconds of arc: the unit, the comment that names it, and what is offered without."""

from __future__ import annotations

import math
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from deltactl.diagnosis.admission.doubts import far_for_a_joint
from deltactl.foundation.errors import ConfigError
from deltactl.models.robot import ServoAxis
from deltactl.recording.foreign.inspection import inspect
from deltactl.recording.foreign.mapping import load_mapping
from deltactl.recording.foreign.reading import read_mapped
from deltactl.recording.tables.flat import from_columns
from tests.rigs.owners_words import owner_says

Deltactl = Callable[..., subprocess.CompletedProcess[str]]
T_S = 4.0 * np.arange(300)
ASKED_ARCSEC = 7000.0 * (1.0 - np.cos(0.006 * T_S)) + 500.0
SEEN_ARCSEC = ASKED_ARCSEC + 0.3 * np.random.default_rng(3).standard_normal(len(T_S))


def write(path: Path, above: str = "", factor: float = 1.0, heading: str = "wanted seen") -> Path:
    rows = np.stack([T_S, factor * ASKED_ARCSEC, factor * SEEN_ARCSEC], axis=1)
    np.savetxt(path, rows, "%.5f", header=f"{above}time {heading}", comments="")
    return path


@pytest.mark.parametrize(("unit", "per_turn"), [("arcsec", 1296000.0), ("arcmin", 21600.0)])
def test_an_angle_is_read_in_parts_of_a_degree(tmp_path: Path, unit: str, per_turn: float) -> None:
    path = write(tmp_path / "a.txt")
    options = ["separator=space", "t=time", f"position=seen[{unit}]", "command=wanted*1e-6"]
    read = read_mapped(path, load_mapping(None, options))
    np.testing.assert_allclose(
        read.column("position"), SEEN_ARCSEC * 2.0 * math.pi / per_turn, atol=1e-6
    )


@pytest.mark.parametrize(
    ("above", "heading", "unit"),
    [
        ("# RA axis, seconds and arcsec\n", "wanted seen", "arcsec"),
        ("% angles in arcminutes\n", "wanted seen", "arcmin"),
        ("", "wanted_arcsec seen_arcsec", "arcsec"),
        ("# tilted by 30 degrees\n# all in arcsec\n", "wanted seen", "arcsec"),
    ],
)
def test_the_unit_of_a_comment_is_used_where_there_is_one(
    tmp_path: Path, above: str, heading: str, unit: str
) -> None:
    found = inspect(write(tmp_path / "a.txt", above, heading=heading))
    assert found.motion == "rotary"
    assert {g.unit for g in found.guesses.values() if g.role != "t"} == {unit}
    read = read_mapped(found.path, load_mapping(None, owner_says(found)))
    per_turn = {"arcmin": 21600.0, "arcsec": 1296000.0}[unit]
    np.testing.assert_allclose(
        read.column("position"), SEEN_ARCSEC * 2.0 * math.pi / per_turn, rtol=1e-4
    )


@pytest.mark.parametrize("above", ["# degrees or arcsec\n", "# arcsec, slide in mm\n", ""])
@pytest.mark.parametrize(("factor", "offered"), [(1.0, True), (0.02, False)])
def test_seconds_of_arc_are_offered_where_it_goes_so_far(
    tmp_path: Path, above: str, factor: float, offered: bool
) -> None:
    found = inspect(write(tmp_path / "a.txt", above, factor))
    assert found.motion is None
    assert found.asked is not None
    assert ("arcsec" in found.asked.rotary) == offered
    assert "mm" in found.asked.linear


def test_inches_are_offered_where_a_heading_has_their_sign(tmp_path: Path) -> None:
    said = " ".join(inspect(write(tmp_path / "a.txt", "", 1.0, 'wanted["] seen["]')).warnings)
    assert "seconds of arc; if it is inches, inspect it" in said
    assert "[deg]" not in said


def test_an_unknown_unit_may_be_a_factor() -> None:
    with pytest.raises(ConfigError, match=r"unit must be one of .*or a factor.*\*4\.848e-6"):
        load_mapping(None, ["position=seen[furlong]"])


def test_a_far_turn_does_not_propose_the_unit_that_was_given() -> None:
    degrees = np.radians(SEEN_ARCSEC)
    read = from_columns({"t": T_S, "command": degrees, "position": degrees}, "a.csv")
    axis = ServoAxis.model_validate({"kind": "servo_axis", "name": "a", "motion": "rotary"})
    doubt = far_for_a_joint(axis, read)
    assert doubt is not None
    line = doubt.says
    assert "[deg]" not in line
    assert 'position=COLUMN*FACTOR"' in line
