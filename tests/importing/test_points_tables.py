"""Tables of points: their units, what of them is not used, and adding a point to one."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from deltactl.firmware_py.importing.drawn import Drawn, held
from deltactl.firmware_py.importing.point_columns import add_point
from deltactl.firmware_py.importing.points_table import read_points
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.foundation.errors import ConfigError, DeltactlError

Deltactl = Callable[..., subprocess.CompletedProcess[str]]
NOWHERE = (0.0, 0.0, 0.0)
PLACE = (0.02, 0.0, -0.3)


def drawn(tmp_path: Path, text: str, origin_m=NOWHERE) -> Drawn:
    path = tmp_path / "points.csv"
    path.write_text(text)
    return read_points(path, origin_m)


@pytest.mark.parametrize(
    "heading",
    ["x,y,z", "X (mm),Y (mm),Z (mm)", "x [mm],y [mm],z [mm]", "x_mm,y_mm,z_mm", "X mm,Y mm,Z mm"],
)
def test_headings_in_millimetres(tmp_path: Path, heading: str) -> None:
    found = drawn(tmp_path, f"{heading}\n0,0,-300\n10,5,-300\n")
    assert list(found.legs) == [{"to_m": (0.01, 0.005, -0.3)}]
    assert found.notes == ()
    assert list(found.lines) == [3]


@pytest.mark.parametrize(
    ("heading", "row", "leg", "note"),
    [
        ("x_m,y_m,z_m", "0.01,0.005,-0.3", {}, "column 'x_m' read in m"),
        ("x [cm],y [cm],z [cm]", "1,0.5,-30", {}, "column 'x [cm]' read in cm"),
        ("x,y,z,F", "10,5,-300,600", {"speed_mps": 0.01}, "column 'F' read in mm/min"),
        ("x,y,z,speed (m/s)", "10,5,-300,0.02", {"speed_mps": 0.02}, "read in m/s"),
        ("x,y,z,dwell [ms]", "10,5,-300,250", {"dwell_s": 0.25}, "read in ms"),
    ],
)
def test_other_units_are_read_and_told(
    tmp_path: Path, heading: str, row: str, leg: dict[str, float], note: str
) -> None:
    first = ",".join(["0", "0", "0", "", ""][: heading.count(",") + 1])
    found = drawn(tmp_path, f"{heading}\n{first}\n{row}\n")
    assert list(found.legs) == [{"to_m": (0.01, 0.005, -0.3)} | leg]
    assert any(note in one for one in found.notes)


def test_the_first_point_waits_and_its_speed_is_told(tmp_path: Path) -> None:
    found = drawn(tmp_path, "x,y,z,speed,dwell\n0,0,-300,30,2\n10,0,-300,,\n")
    assert found.legs[0] == {"to_m": (0.0, 0.0, -0.3), "dwell_s": 2.0}
    assert list(found.lines) == [2, 3]
    assert found.notes == ("the first point's speed passed over: no move leads to it",)


def test_a_table_without_z_lies_at_the_height_of_the_origin(tmp_path: Path) -> None:
    found = drawn(tmp_path, "x,y\n0,0\n10,0\n", (0.0, 0.0, -0.45))
    assert list(found.legs) == [{"to_m": (0.01, 0.0, -0.45)}]
    assert found.notes == ("no z: every point at the height of --origin",)


def test_speeds_above_that_of_the_job_are_told(tmp_path: Path) -> None:
    found = drawn(tmp_path, "x,y,z,speed\n0,0,-300,\n10,0,-300,120\n20,0,-300,20\n")
    assert "above --speed 50 mm/s are held to it: up to 120 mm/s, in 1 of 2" in held(found, 0.05)
    assert held(found, 0.2) == ""


def test_a_taught_wait_at_the_first_point_is_waited_for(deltactl: Deltactl, tmp_path: Path) -> None:
    table = tmp_path / "pick.csv"
    add_point(table, (0.0, 0.0, -0.45), 2.0)
    add_point(table, (0.02, 0.0, -0.45), 0.0)
    deltactl("convert", "pick.csv", "pick.yaml", "--robot", "zhao-2023.yaml")
    summary = json.loads(deltactl("check", "pick.yaml", "--json").stdout)
    assert summary["duration_s"] > summary["moving_s"] + summary["approach_s"] + 1.99
    table.write_text("x,y,z\n0,0,-450\n900,0,-450\n")
    refused = deltactl(
        "convert", "pick.csv", "far.yaml", "--robot", "zhao-2023.yaml", status=2
    ).stderr
    assert "pick.csv:3: " in refused


@pytest.mark.parametrize(
    ("before", "dwell_s", "after"),
    [
        ("", 0.5, "x_mm,y_mm,z_mm,dwell_s\n20,0,-300,0.5\n"),
        ("x,y,z\n1,2,-300", 0.0, "x,y,z\n1,2,-300\n20,0,-300\n"),
        ("z;speed;x;y\n-300;5;1,5;2\n", 0.0, "z;speed;x;y\n-300;5;1,5;2\n-300;;20;0\n"),
        ("x_m,y_m,z_m,dwell_ms\n", 0.5, "x_m,y_m,z_m,dwell_ms\n0.02,0,-0.3,500\n"),
        ("1 2 -300\n4 5 -300\n", 0.0, "1 2 -300\n4 5 -300\n20\t0\t-300\n"),
        ("x,y,z,tool\n1,2,-300,7\n", 0.0, "x,y,z,tool\n1,2,-300,7\n20,0,-300,\n"),
    ],
)
def test_a_point_is_added_in_the_tables_own_columns(
    tmp_path: Path, before: str, dwell_s: float, after: str
) -> None:
    table = tmp_path / "points.csv"
    if before:
        table.write_text(before)
    add_point(table, PLACE, dwell_s)
    assert table.read_text() == after


def test_a_file_that_is_no_table_of_points_is_left_as_it_was(tmp_path: Path) -> None:
    robot = tmp_path / "robot.yaml"
    robot.write_text((CONFIG_FOLDER / "zhao-2023.yaml").read_text())
    log, short = tmp_path / "log.csv", tmp_path / "short.csv"
    log.write_text("t,angle\n0,1\n1,2\n")
    short.write_text("x,y,z\n1,2,-300\n")
    disguised = tmp_path / "robot.csv"
    disguised.write_text(robot.read_text())
    for path, dwell_s, says in (
        (robot, 0.0, "teach adds to a table of points"),
        (log, 0.0, "is no table of points with columns x, y and z"),
        (disguised, 0.0, "is no table of points"),
        (short, 0.5, "has no column for --dwell"),
    ):
        was = path.read_text()
        with pytest.raises(ConfigError, match=says):
            add_point(path, PLACE, dwell_s)
        assert path.read_text() == was


@pytest.mark.parametrize(
    ("cell", "says"), [("", "y_mm is empty; a point needs"), ("abc", "y_mm must be a number")]
)
def test_an_empty_coordinate_is_told_by_line_and_column(
    tmp_path: Path, cell: str, says: str
) -> None:
    """As text in its place is; it was a point that somebody had to count to."""
    with pytest.raises(DeltactlError, match=rf"points\.csv:4: {says}"):
        drawn(tmp_path, f"x_mm,y_mm,z_mm\n0,0,-450\n\n10,{cell},-450\n20,0,-450\n")


@pytest.mark.parametrize(
    ("text", "lines"),
    [
        ("x,y,z,speed\n1,5,0,\n15,9,0,-5\n15,0,0,0\n0,0,0,nan\n", (3, 4, 5)),
        ("x,y,z,dwell\n1,5,0,\n1,2,0,-1\n3,4,0,inf\n3,5,0,soon\n", (3, 4, 5)),
        ("x,y,z\n1,5,0\n1,nan,0\n2,,0\n3,4\n3,4,5,6\n1,2,0x1\n" + "7,8,0\n" * 6, (3, 4, 5, 6, 7)),
        ("x,y,z\n1,2\n1,2,3\n3,4,5\n", (2,)),
        ("x;y;z\n1,5;2;3\n1.5;2;3\n2,5;1;1\n", (3,)),
        ("x,y,z,speeed\n1,2,3,4\n4,5,6,7\n", (1,)),
        ("x,y,z,speed [furlong]\n1,2,3,4\n4,5,6,7\n", (1,)),
        ("# points\nx,y,z [deg]\n1,2,3\n4,5,6\n", (2,)),
        ("x,y,z,X\n1,2,3,4\n4,5,6,7\n", (1,)),
        ("x,y,z,v,feed\n1,2,3,4,5\n4,5,6,7,8\n", (1,)),
        ("x [mm],y,z\nm,m,m\n1,2,3\n4,5,6\n", (1,)),
        ("a,y,q\n1,2,3\n4,5,6\n", (1, 1, 1)),
        ("1,2,3,4,5,6\n4,5,6,7,8,9\n", (1,)),
    ],
)
def test_what_a_table_says_is_taken_literally_or_refused_with_its_line(
    tmp_path: Path, text: str, lines: tuple[int, ...]
) -> None:
    """A bad speed or a heading nobody knew was dropped, and the leg ran at full speed."""
    with pytest.raises(ConfigError) as error:
        drawn(tmp_path, text)
    assert tuple(int(str(one).split(":")[1]) for one in error.value.args) == lines


def test_a_column_is_left_out_by_its_name_alone(tmp_path: Path) -> None:
    path = tmp_path / "points.csv"
    path.write_text("x,y,z,tool\n0,0,-300,a\n10,0,-300,b\n20,0,-300,4\n")
    found = read_points(path, NOWHERE, skip=("tool",))
    assert len(found.legs) == 2
    assert "column 'tool' passed over" in found.notes
    with pytest.raises(ConfigError, match="is no column of it"):
        read_points(path, NOWHERE, skip=("tol",))


def test_lines_above_a_table_are_named_and_units_below_its_heading_hold(tmp_path: Path) -> None:
    found = drawn(tmp_path, "Points of Monday\nx,y,z\ncm,cm,cm\n1,2,-30\n4,5,-30\n")
    assert found.legs[0]["to_m"] == (0.04, 0.05, -0.3)
    assert "'Points of Monday' above the table passed over" in found.notes


def test_twenty_mistakes_of_a_table_are_told(tmp_path: Path) -> None:
    with pytest.raises(ConfigError) as error:
        drawn(tmp_path, "x,y,z,speed\n1,2,3,\n" + "1,2,3,-1\n" * 100)
    assert len(error.value.args) == 21
