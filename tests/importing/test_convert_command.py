"""G-code and tables of points become jobs that run."""

from __future__ import annotations

import json
import math
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.firmware_py.importing.gcode import read_gcode
from deltactl.firmware_py.importing.points_table import read_points
from deltactl.firmware_py.job_file import load_job
from deltactl.foundation.errors import ConfigError

Deltactl = Callable[..., subprocess.CompletedProcess[str]]
PART = """\
%
(a square with a rounded corner)
N10 G21 G90 G17
N20 G0 X0 Y0 Z0
G1 X40 F1200 ; feed in mm a minute
Y30
G3 X30 Y40 I-10 J0
G4 P250
G91
G1 X-30
G90
G20
G1 X0 Y0 F60
M5
"""
ORIGIN = (0.0, 0.0, -0.45)


def gcode(tmp_path: Path, text: str):
    (tmp_path / "part.gcode").write_text(text)
    return read_gcode(tmp_path / "part.gcode", ORIGIN)


def test_gcode_is_read(tmp_path: Path) -> None:
    drawn = gcode(tmp_path, PART)
    assert drawn.start_m == (0.0, 0.0, -0.45)
    to = [tuple(leg["to_m"]) for leg in drawn.legs]
    assert to == [
        (0.04, 0.0, -0.45), (0.04, 0.03, -0.45), (0.03, 0.04, -0.45), (0.0, 0.04, -0.45),
        (0.0, 0.0, -0.45),
    ]  # fmt: skip
    assert drawn.legs[0]["speed_mps"] == pytest.approx(0.02)
    assert drawn.legs[2]["centre_m"] == (0.03, 0.03)
    assert drawn.legs[2]["clockwise"] is False
    assert drawn.legs[2]["dwell_s"] == 0.25
    assert drawn.legs[4]["speed_mps"] == pytest.approx(0.0254)
    assert drawn.notes[0] == "M5 passed over (once)"


def test_every_word_that_is_passed_over_is_listed(tmp_path: Path) -> None:
    drawn = gcode(tmp_path, "M3 S200\nT1\nG1 X1 Y0 Z0 F600 E1.2\nG1 X0 Y1 E2\n")
    assert drawn.notes == tuple(
        f"{word} passed over ({often})"
        for word, often in (("M3", "once"), ("S", "once"), ("T1", "once"), ("E", "2 times"))
    )


@given(st.sampled_from([2, 3]), st.floats(5.0, 40.0), st.floats(-3.1, 3.1), st.floats(0.1, 6.1))
@settings(max_examples=25, deadline=None)
def test_an_arc_by_r_is_the_arc_by_its_centre(
    tmp_path_factory: pytest.TempPathFactory, code: int, radius: float, first: float, swing: float
) -> None:
    if abs(swing - math.pi) < 0.02:  # half a turn: which side is a matter of rounding
        return
    angles = (first, first + (swing if code == 3 else -swing))
    (x0, y0), (x1, y1) = ((radius * math.cos(a), radius * math.sin(a)) for a in angles)
    folder = tmp_path_factory.mktemp("arc")
    head = f"G21 G90\nG0 X{x0:.9f} Y{y0:.9f} Z0\nG{code} X{x1:.9f} Y{y1:.9f} "
    signed = radius if swing < math.pi else -radius
    by_r = gcode(folder, f"{head}R{signed:.9f}\n").legs[0]
    by_centre = gcode(folder, f"{head}I{-x0:.9f} J{-y0:.9f}\n").legs[0]
    assert by_r["centre_m"] == pytest.approx(by_centre["centre_m"], abs=1e-6)
    assert by_r["clockwise"] is by_centre["clockwise"] is (code == 2)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("G0 X0 Y0 Z0\nG5 X1\n", ":2: G5 curves of this kind are not taken"),
        ("G0 X0 Y0 Z0\nG2 X1 Y1\n", ":2: an arc needs I and J"),
        ("G0 X0 Y0 Z0\nG2 X20 Y0 R9\n", ":2: R 9 cannot reach: half the distance is 10"),
        ("G0 X0 Y0 Z0\nG2 X0 Y0 R9\n", ":2: an arc by R needs another place"),
        ("G91\nG1 X1\n", ":2: G91 comes before any absolute place"),
        ("G4 P1\n", "holds no moves"),
        ("G0 X0 Y0 Z0\nhello\n", ":2: 'hello' is not understood"),
        ("G21\n", "holds no moves"),
    ],
)
def test_what_is_not_taken_is_named_with_its_line(tmp_path: Path, text: str, says: str) -> None:
    with pytest.raises(ConfigError, match=r"part\.gcode") as error:
        gcode(tmp_path, text)
    assert says in str(error.value)


def test_a_table_of_points(tmp_path: Path) -> None:
    path = tmp_path / "points.csv"
    path.write_text("X;Y;Z;Speed;Dwell\n0;0;0;;\n10,5;0;0;20;\n10,5;20;0;;1,5\n")
    drawn = read_points(path, ORIGIN)
    assert drawn.legs[0] == {"to_m": (0.0105, 0.0, -0.45), "speed_mps": 0.02}
    assert drawn.legs[1] == {"to_m": (0.0105, 0.02, -0.45), "dwell_s": 1.5}


def test_from_gcode_to_a_run(deltactl: Deltactl, tmp_path: Path) -> None:
    (tmp_path / "part.gcode").write_text(PART)
    options = ["--robot", "zhao-2023.yaml", "--origin", "0 0 -450", "--corner", "0.5"]
    shown = deltactl("convert", "part.gcode", "part.yaml", *options)
    assert "part may run" in shown.stdout
    assert "M5 passed over" in shown.stderr
    job = load_job(tmp_path / "part.yaml")
    assert job.path.corner_m == 0.0005
    done = json.loads(deltactl("run", "part.yaml", "--simulate", "--json").stdout)
    assert done["outcome"] == "done"
    refused = deltactl("convert", "part.gcode", "part.yaml", *options, status=2)
    assert "--force" in refused.stderr


def test_a_job_that_may_not_run_is_not_left_behind(deltactl: Deltactl, tmp_path: Path) -> None:
    (tmp_path / "far.csv").write_text("x,y,z\n0,0,-450\n900,0,-450\n")
    words = ("convert", "far.csv", "far.yaml", "--robot", "zhao-2023.yaml")
    refused = deltactl(*words, status=2)
    assert refused.stderr.rstrip().endswith("no job was written")
    assert not refused.stdout
    assert not (tmp_path / "far.yaml").exists()
    (tmp_path / "far.yaml").write_text("mine")
    deltactl(*words, "--force", status=2)
    assert (tmp_path / "far.yaml").read_text() == "mine"
    (tmp_path / "far.csv").write_text("x,y,z\n0,0,-450\n9,0,-450\n")
    said = deltactl(*words, "--force").stdout
    assert "job: far.yaml, one leg" in said
    assert "next: deltactl run far.yaml" in said


def test_corners_are_rounded_where_nobody_says_otherwise(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    (tmp_path / "path.csv").write_text("x,y,z,dwell\n0,0,0,\n30,0,0,\n30,30,0,1\n0,30,0,\n")
    options = ["--robot", "zhao-2023.yaml", "--origin", "0 0 -450", "--force"]
    said = deltactl("convert", "path.csv", "path.yaml", *options).stdout
    assert "corners are rounded by up to 0.5 mm; --corner 0 stops at each point" in said
    job = load_job(tmp_path / "path.yaml")
    assert job.path.corner_m == 0.0005
    assert job.path.legs.dwell_s[1] == 1.0
    said = deltactl("convert", "path.csv", "path.yaml", *options, "--corner", "0").stdout
    assert "rounded" not in said
    said = deltactl("convert", "path.csv", "path.yaml", *options, "--spline").stdout
    assert "rounded" not in said


@pytest.mark.study
def test_goto_on_the_simulated_robot(deltactl: Deltactl) -> None:
    arguments = ["20", "-10", "-450", "--robot", "zhao-2023.yaml", "--simulate", "--json"]
    done = json.loads(deltactl("goto", *arguments).stdout)
    assert done["outcome"] == "done"
    refused = deltactl("goto", "900", "0", "-450", "--robot", "zhao-2023.yaml", status=2)
    assert "out of reach" in refused.stderr
    assert "--robot" in deltactl("goto", "0", "0", "-450", status=2).stderr
    said = deltactl("goto", "0", "0", "-450", "--robot", "zhao-2023.yaml", "--simulate").stdout
    assert "nothing to compare" not in said
    assert "nan" not in said


def test_a_corner_row_of_numbers_without_a_heading(tmp_path: Path) -> None:
    path = tmp_path / "points.txt"
    path.write_text("\n".join(f"{x} {x * x / 40} -5" for x in np.linspace(0, 40, 9)))
    assert len(read_points(path, ORIGIN).legs) == 8


@pytest.mark.parametrize("word", ["fast", "1_0", "１２", "inf"])
def test_what_is_no_number_where_a_speed_should_be_is_refused_with_its_line(
    tmp_path: Path, word: str
) -> None:
    table = tmp_path / "points.csv"
    table.write_text(f"x,y,z,speed\n0,0,-450,10\n10,0,-450,\n20,5,-450,{word}\n")
    says = rf"points.csv:4: speed must be a number \(got '{word}'\)"
    with pytest.raises(ConfigError, match=says):
        read_points(table, (0.0, 0.0, 0.0))
