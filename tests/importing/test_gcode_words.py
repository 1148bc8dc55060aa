"""Words of a line are what people and posts mean by them, and nothing is left out unsaid."""

from __future__ import annotations

from pathlib import Path

import pytest
from gcodeparser import parse_gcode_lines
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.firmware_py.importing.drawn import Drawn
from deltactl.firmware_py.importing.gcode import read_gcode
from deltactl.firmware_py.importing.gcode_words import words_of
from deltactl.foundation.errors import ConfigError

HEAD = "G21 G90\nG0 X0 Y0 Z0\n"


def drawn(tmp_path: Path, text: str, origin_m=(0.0, 0.0, -0.45)) -> Drawn:
    path = tmp_path / "part.nc"
    path.write_text(text)
    return read_gcode(path, origin_m)


def ends_mm(tmp_path: Path, text: str) -> list[tuple[float, float, float]]:
    """Where the moves of a file end, z from the origin."""
    legs = drawn(tmp_path, text, (0.0, 0.0, 0.0)).legs
    return [tuple(round(1e3 * value, 6) for value in leg["to_m"]) for leg in legs]


plain = st.lists(
    st.tuples(st.sampled_from("XYZIJRFS"), st.integers(-99999, 99999)),
    min_size=1, max_size=5, unique_by=lambda one: one[0],
)  # fmt: skip


@given(st.sampled_from(["G0", "G1", "G02", "M3"]), plain)
@settings(max_examples=40, deadline=None)
def test_words_are_those_of_gcodeparser_where_that_can_read_them(command: str, words) -> None:
    line = " ".join([command, *(f"{letter}{value / 1000:.3f}" for letter, value in words)])
    (theirs,) = parse_gcode_lines(line)
    ours = words_of(line)
    assert (ours[0].letter, int(ours[0].value)) == theirs.command
    assert {word.letter: word.value for word in ours[1:]} == theirs.params


@pytest.mark.parametrize(
    ("line", "texts"),
    [
        ("N10 g1x10y-.5 (to the right) f100 ; slow", ["G1", "X10", "Y-0.5", "F100"]),
        ("G90 G94 G91.1", ["G90", "G94", "G91.1"]),
        ("X 10 Y +5.", ["X10", "Y5"]),
        ("G1 X5 *27", ["G1", "X5"]),
        ("( nothing )", []),
    ],
)
def test_a_line_as_it_is_written(line: str, texts: list[str]) -> None:
    assert [word.text for word in words_of(line)] == texts


@pytest.mark.parametrize(
    "line", ["G1 X#3", "G1 X[1+2]", "G1 X1.2.3", "G1 X5*71", "(open G1 X5", "/G1 X5"]
)
def test_what_cannot_be_read_is_not_read_half(line: str) -> None:
    with pytest.raises(ValueError, match=r"."):
        words_of(line)


def test_the_preamble_of_common_posts_does_not_make_the_file_relative(tmp_path: Path) -> None:
    text = (
        "G90 G94 G91.1 G40 G49 G17\nG21\nT1 M6\nS1000 M3\nG54\nG0 X0 Y0 Z5\nG1 X10 Y5 F600\nX20\n"
    )
    assert ends_mm(tmp_path, text) == [(10, 5, 5), (20, 5, 5)]
    notes = drawn(tmp_path, text).notes
    assert notes == tuple(f"{word} passed over (once)" for word in ("T1", "M6", "M3", "S"))


@pytest.mark.parametrize(
    ("text", "ends"),
    [
        ("G91 X10\nX5\nG90 X0 Y0\n", [(10, 0, 0), (15, 0, 0), (0, 0, 0)]),
        ("G1 G91 X5 F100\nX5\n", [(5, 0, 0), (10, 0, 0)]),
        ("G1 F100\nX10 Y5\nY7\n", [(10, 5, 0), (10, 7, 0)]),
        ("G1X1\nN20 X2\nn30x3\n", [(1, 0, 0), (2, 0, 0), (3, 0, 0)]),
        ("G20 X1\n", [(25.4, 0, 0)]),
        ("G1 X1\nM30\nG1 X50\n", [(1, 0, 0)]),
        ("G1 X1\nG92 E0\nG1 X2 E1\n", [(1, 0, 0), (2, 0, 0)]),
    ],
)
def test_words_of_one_line_act_together(tmp_path: Path, text: str, ends) -> None:
    assert ends_mm(tmp_path, HEAD + text) == ends


@pytest.mark.parametrize("centre", ["G91.1\nG2 X20 Y0 I10 J0", "G90.1\nG2 X20 Y0 I10 J0"])
def test_centres_are_offsets_or_places(tmp_path: Path, centre: str) -> None:
    (leg,) = drawn(tmp_path, HEAD + centre + "\n").legs
    assert leg["centre_m"] == (0.01, 0.0)
    text = f"G0 X10 Y0 Z0\n{centre.replace('X20', 'X30')}\n"
    if "G90.1" in centre:  # the place itself is no centre of this arc any more
        text = text.replace("I10", "I20")
    (leg,) = drawn(tmp_path, text).legs
    assert leg["centre_m"] == (0.02, 0.0)


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("G18", "G18 arcs in XZ cannot be made"), ("G19", "G19 arcs in YZ"),
        ("G41 D1", "G41 the tool's radius"), ("G42", "G42 the tool's radius"),
        ("G28", "G28 goes to a place"), ("G53 G0 X0", "G53 is a place in the machine's own"),
        ("G92 X0", "G92 moves the origin"), ("G55", "G55 other origins"),
        ("G2 X1 Y1 I1 K2", "G2 with K"), ("G93", "G93 F as a time"),
        ("G0 G1 X1", "two of the moves"), ("X1 X2", "two words X"),
        ("G90.1 G2 X1 Y1 I1", "an arc under G90.1 needs"), ("M98 P100", "M98 calls another part"),
        ("G80\nX1", "coordinates after G80"), ("G1 X1\nG4", "G4 needs one of P"),
        ("G1 X1 F0", "F must be above 0"),
    ],
)  # fmt: skip
def test_what_would_change_the_path_is_refused_with_its_line(
    tmp_path: Path, line: str, says: str
) -> None:
    text = HEAD + line + "\n"
    with pytest.raises(ConfigError) as error:
        drawn(tmp_path, text)
    number = text.count("\n")
    assert f"part.nc:{number}: {says}" in str(error.value)


@pytest.mark.parametrize(
    ("word", "seconds"), [("P1500", 1.5), ("S1.5", 1.5), ("X1.5", 1.5), ("U2", 2.0)]
)
def test_a_wait_is_as_long_as_is_said(tmp_path: Path, word: str, seconds: float) -> None:
    found = drawn(tmp_path, f"{HEAD}G1 X5\nG4 {word}\nG1 X9\n")
    assert found.legs[0]["dwell_s"] == seconds
    assert any("G4 P taken as milliseconds" in note for note in found.notes) is (word[0] == "P")
    assert found.legs[1]["to_m"][0] == 0.009


def test_a_drawing_without_z_lies_at_the_height_of_the_origin(tmp_path: Path) -> None:
    found = drawn(tmp_path, "G0 X0 Y0\nG1 X10 F600\n")
    assert found.legs[0]["to_m"] == (0.01, 0.0, -0.45)
    assert found.notes == ("no z: every point at the height of --origin",)


def test_moves_before_all_places_are_known_are_told(tmp_path: Path) -> None:
    found = drawn(tmp_path, "G1 X0 Y0\nG1 X10\nG1 Z5\nX20\n")
    assert len(found.legs) == 1
    assert "moves before X, Y and Z are all known left out (2 times)" in found.notes
