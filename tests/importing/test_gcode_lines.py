"""Every character of a line of G-code is understood, passed over by name, or refused with it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

from deltactl.firmware_py.importing.drawn import Drawn
from deltactl.firmware_py.importing.gcode import read_gcode
from deltactl.firmware_py.importing.gcode_tables import meanings_of
from deltactl.foundation.errors import ConfigError

HEAD = "G21 G90\nG0 X10 Y0 Z0\nG1 X0 F600\n"
OUTPUTS = ("spindle", "fan")


def drawn(
    tmp_path: Path,
    text: str | bytes,
    skip: Sequence[str] = (),
    codes: Sequence[str] = (),
    block_delete: bool | None = None,
) -> Drawn:
    path = tmp_path / "part.nc"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_gcode(path, (0.0, 0.0, 0.0), meanings_of(skip, codes, OUTPUTS, block_delete))


def ends_mm(found: Drawn) -> list[tuple[float, ...]]:
    return [tuple(round(1e3 * value, 6) for value in leg["to_m"]) for leg in found.legs]


MARLIN = [
    "M92 X80 Y80 Z400", "M201 X500 Y500", "M203 X200 Y200", "M204 P800 T1000", "M205 X8 Y8 Z0.4",
    "M208 X200 Y200", "M425 X0.1", "M420 S1 Z5", "M566 X600 Y600", "M593 X F40", "M851 X1 Y2 Z-1",
    "M906 X800", "M913 X100", "M84 X Y E", "M18 E", "M104 S200", "M107", "M117 X5 is next :)",
    "M73 P10 R5", "M862.3 P \"MK3S\"", "M115 U3.9.1", "m205x8y8", "M 205 X 8", "N7 M205 X8",
]  # fmt: skip


@pytest.mark.parametrize("line", MARLIN)
def test_words_after_an_m_word_of_a_printer_are_no_coordinates(tmp_path: Path, line: str) -> None:
    found = drawn(tmp_path, f"{HEAD}{line}\nG1 X5\n")
    assert ends_mm(found) == [(0, 0, 0), (5, 0, 0)]
    code = line.split()[-1] if line.startswith("N7") else line
    assert any("passed over" in note and note[0] == "M" for note in found.notes), code


@pytest.mark.parametrize("line", ["M3 S100 X5", "X5 M8", "M5X5", "G1 M9 X5", "T1 M6 X5", "M30 X5"])
def test_spindle_coolant_tool_and_end_share_a_line_with_a_move(tmp_path: Path, line: str) -> None:
    assert ends_mm(drawn(tmp_path, f"{HEAD}{line}\n")) == [(0, 0, 0), (5, 0, 0)]


@pytest.mark.parametrize(
    "line",
    [
        "G1 X", "X5 Y", "X1e3", "X1E-05", "G1X1E-05", "g1 x1.5e+2", "X--5", "X- 5", "X1.2.3",
        "X1 2", "X1,5", "X0x10", "Xnan", "Xinf", "X1_0", "X\u22125", "X\uff11", "X5\u00a0",
        "X" + "9" * 400, "X#1", "X[1+2]", "#1=5", "o100 sub", "o<a> call", "O200", "/G1 X5",
        "X5 Q1", "G1 X5 P1",
        "G1 X5 I1", "G1 X5 R1", "G2 X5 I2.5 P2", "G2 X5 I2.5 R2.5", "A5", "X5 C90", "U1", "N5 N6",
        "X5 N6", "X5 X6", "M3.5 X5", "M", "G", "G1.5 X5", "G-1 X5", "M-3", "(open X5", "X5) X6",
        "(a (b) X5 (c))", "X5*71", "N3 G1 X5*12", "G1 X5 M205 X8", "M104 S200 G1 X5", "M2 X",
        "G92", "G92 X0", "G92 X0 E0", "G10 L2 P1 X0", "G50 X5", "G52 X1", "G43.1 Z5", "G16",
        "G5 X1", "G81 Z-5 R1", "G38.2 Z-5", "G28 G1 X5", "G4 P1 S1", "G4", "G4 X-1", "G4 P1 Z5",
        "G4 S4000", "M206 X5", "M290 Z1", "M220 S50", "M98 P1", "M32 a.g", "M28 a.g", "M808 L5",
        "M70", "M72",
        "M73", "M66 P1", "M48 P4 X5", "M112", "M1234", "START_PRINT BED=60", "hello", "X5 %",
        "G1 X5 F-1", "G1 X5 \x00", "G1 \x00X5",
    ],
)  # fmt: skip
def test_what_cannot_be_carried_out_as_it_says_is_refused_with_its_line(
    tmp_path: Path, line: str
) -> None:
    with pytest.raises(ConfigError, match=r"part\.nc:4: "):
        drawn(tmp_path, f"{HEAD}{line}\nG1 X9\n")


@pytest.mark.parametrize(
    ("line", "end"),
    [
        ("g1x5y-.5", (5, -0.5)), ("X+5.", (5, 0)), ("X 5 Y .5", (5, 0.5)), ("X0005", (5, 0)),
        ("G01 X5", (5, 0)), ("G 1 X5", (5, 0)), ("N10X5", (5, 0)), ("N 10 g1 x5", (5, 0)),
        ("X(half)5", (5, 0)), ("G1 X5 ; (open", (5, 0)), ("(drill (5 mm) hole) X5", (5, 0)),
        ("X5 (it; goes)", (5, 0)), ("N3 G1 X5*102", (5, 0)), ("G1X5E2", (5, 0)), ("X5 E1", (5, 0)),
        ("X5 A0 B0.0", (5, 0)), ("G54 X5", (5, 0)), ("G64 P0.01 X5", (5, 0)), ("G43 H1 X5", (5, 0)),
        ("\tX5\t", (5, 0)), ("X5 S1000 T1", (5, 0)), ("G91 X5 G90", (5, 0)), ("X5 (3*4)", (5, 0)),
    ],
)  # fmt: skip
def test_ways_to_write_a_line(tmp_path: Path, line: str, end: tuple[float, float]) -> None:
    line = "G91 X5" if line == "G91 X5 G90" else line
    assert ends_mm(drawn(tmp_path, f"{HEAD}{line}\n"))[-1][:2] == end


@pytest.mark.parametrize(
    "content",
    [
        b"\xef\xbb\xbfG0 X0 Y0 Z0\r\nX5\r\n", b"G0 X0 Y0 Z0\nX5\n\x1a", b"G0 X0 Y0 Z0\nX5\n\0\0",
        b"\x00\x00%\nG0 X0 Y0 Z0\nX5\n%\n\x13\x04", b"G0 X0 Y0 Z0 (\xe9\x85X9)\rX5 ; \xb5 X7\r",
        "G0 X0 Y0 Z0 ; é\u2028X9\nX5".encode(), "G0 X0 Y0 Z0\nX5\n".encode("utf-16"),
        b"G0 X0 Y0 Z0\n\rX5\n\r", b"G0 X0 Y0 Z0\r\r\nX5\r\r\n",
        b"%\nO1001 (PART)\nG0 X0 Y0 Z0\nX5\nM30\n%\nX7", b":7\nG0 X0 Y0 Z0\nX5\nM2\nX7\n",
    ],
)  # fmt: skip
def test_bytes_that_editors_and_old_controllers_leave_do_no_harm(
    tmp_path: Path, content: bytes
) -> None:
    found = drawn(tmp_path, content)
    assert ends_mm(found) == [(5, 0, 0)]
    if b"X7" in content and b"; " not in content:
        assert any("behind the end of the program left out" in note for note in found.notes)


def test_lines_are_counted_as_editors_do(tmp_path: Path) -> None:
    for text in (b"(a)\n\n\nG18\n", b"(a)\r\n\r\n\r\nG18\r\n", b"(\x85)\r\r\rG18\r", b"\n\n\nG18"):
        with pytest.raises(ConfigError, match=r"part\.nc:4: G18"):
            drawn(tmp_path, text)


def test_all_mistakes_of_a_file_are_told_at_most_twenty(tmp_path: Path) -> None:
    with pytest.raises(ConfigError) as few:
        drawn(tmp_path, f"{HEAD}G18\nX1,5\nG2 X9\nM206 X1\nG1 X5\n")
    assert [one.split(":")[1] for one in few.value.args] == ["4", "5", "6", "7"]
    with pytest.raises(ConfigError) as many:
        drawn(tmp_path, HEAD + "G18\n" * 300)
    assert len(many.value.args) == 21
    assert "more mistakes" in many.value.args[-1]


@pytest.mark.parametrize(
    ("lines", "says"),
    [
        ("M0 (swap the part)", "swap the part"), ("M0 swap the part", "swap the part"),
        ("M1", "M1"), ("M25", "M25"), ("M60", "M60"), ("M226", "M226"), ("M600 X5 Y5", "M600"),
        ("M601", "M601"), ("M125", "M125"), ("M400 U1", "M400"), ("T2 M6", "M6"),
        ("n9 m00", "M0"), ("M5 M0", "M0"),
    ],
)  # fmt: skip
def test_where_a_hand_may_be_in_the_machine_the_job_waits(
    tmp_path: Path, lines: str, says: str
) -> None:
    found = drawn(tmp_path, f"{HEAD}{lines}\nG1 X-5\n")
    ((legs_before, step),) = found.between
    assert legs_before == 1
    assert says in step["pause"]
    assert ends_mm(found) == [(0, 0, 0), (-5, 0, 0)]


def test_a_stop_on_the_line_of_a_move_comes_after_it(tmp_path: Path) -> None:
    found = drawn(tmp_path, f"{HEAD}M0 X5\nX9\n")
    assert [before for before, _ in found.between] == [2]


def test_waits_before_the_first_place_are_left_out_and_named(tmp_path: Path) -> None:
    found = drawn(tmp_path, f"G21\nM3 S9\nG4 P1000\n{HEAD}")
    assert ends_mm(found) == [(0, 0, 0)]
    assert any(note.startswith("G4 before the first place") for note in found.notes)


def test_a_wait_that_is_left_out_shows_the_unit_of_the_others(tmp_path: Path) -> None:
    found = drawn(tmp_path, f"G21\nM3 S9\nG4 P0.5\n{HEAD}X5\nG4 P2\nX9\n")
    assert [leg.get("dwell_s", 0.0) for leg in found.legs] == pytest.approx([0.0, 2.0, 0.0])


def test_switched_outputs_and_their_waits_are_steps(tmp_path: Path) -> None:
    codes = ["M3=spindle on", "M5=spindle off", "M106=fan on", "M107=fan off"]
    text = f"M3 S900\nG4 S2\n{HEAD}M106 S0\nM106 S255\nS0\nX5\nM05\nM107\n"
    found = drawn(tmp_path, text, codes=codes)
    assert found.between == (
        (-1, {"set": {"spindle": True}}), (-1, {"wait_s": 2.0}), (1, {"set": {"fan": False}}),
        (1, {"set": {"fan": True}}), (1, {"set": {"spindle": False}}),
        (2, {"set": {"fan": False}}),
    )  # fmt: skip


def test_g28_is_left_out_or_a_place_as_the_options_say(tmp_path: Path) -> None:
    slicer = "G28\nG1 Z5 F900\nG92 E0\nG1 X1 Y2 F900\nG1 X5\nG28 X Y\nM84\n"
    found = drawn(tmp_path, slicer, skip=["G28"])
    assert (found.start_m, ends_mm(found)) == ((0.001, 0.002, 0.005), [(5, 2, 5)])
    found = drawn(tmp_path, slicer, codes=["G28=0 0 50"])
    assert found.start_m == (0.0, 0.0, 0.05)
    assert ends_mm(found)[-1] == (0, 0, 5)
    for more in ("G1 X7", "G91 G1 X1"):
        with pytest.raises(ConfigError, match=r"nc:8: Y is not known|nc:8: X, Y"):
            drawn(tmp_path, slicer + more, skip=["G28"])


HOME = ["G28=0 0 50", "G30=0 0 60"]


@pytest.mark.parametrize(
    ("line", "ends"),
    [
        ("G28 X5 Y6", [(5, 6, 5), (0, 0, 5)]),
        ("G28 Z20", [(1, 2, 20), (1, 2, 50)]),
        ("G91 G28 Z0", [(1, 2, 50)]),
        ("G91 G30 Z10", [(1, 2, 15), (1, 2, 60)]),
        ("G28 X1 Y2 Z5", [(0, 0, 50)]),
        ("G28 X Z", [(0, 2, 50)]),
        ("G28", [(0, 0, 50)]),
    ],
)
def test_home_is_gone_to_by_way_of_the_place_that_the_line_gives(
    tmp_path: Path, line: str, ends: list[tuple[float, ...]]
) -> None:
    found = drawn(tmp_path, f"G0 X1 Y2 Z5\n{line}\n", codes=HOME)
    assert ends_mm(found) == ends
    assert any("by way of" in note for note in found.notes) == (len(ends) > 1)


DELETED = ["/G1 X5", "/ G1 X5", "/N20 G1 X5", "N20 / G1 X5", "/2 G1 X5", "\t/G1 X5 (a test cut)"]


@pytest.mark.parametrize("line", DELETED)
def test_block_delete_is_the_users_choice(tmp_path: Path, line: str) -> None:
    text = f"{HEAD}{line}\nG1 Y8\n"
    with pytest.raises(ConfigError, match=r"part\.nc:4: .*--block-delete .*--no-block-delete"):
        drawn(tmp_path, text)
    assert ends_mm(drawn(tmp_path, text, block_delete=True)) == [(0, 0, 0), (0, 8, 0)]
    assert ends_mm(drawn(tmp_path, text, block_delete=False))[1:] == [(5, 0, 0), (5, 8, 0)]
    for choice in (True, False):
        assert any("with /" in note for note in drawn(tmp_path, text, block_delete=choice).notes)


def test_lines_that_are_carried_out_are_checked_as_others_are(tmp_path: Path) -> None:
    for line in ("/G1 X5 Q1", "G1 X5 / Y7", "//G1 X5"):
        with pytest.raises(ConfigError, match=r"part\.nc:4: "):
            drawn(tmp_path, f"{HEAD}{line}\n", block_delete=False)
    assert len(drawn(tmp_path, f"{HEAD}/G1 X5 Q1\n", block_delete=True).legs) == 1


@pytest.mark.parametrize("first", ["G1 X5 Q1", "G1 X5,5", "(a G1 X5", "G1 F0 X5", "M205 G1"])
def test_arcs_behind_a_mistake_are_checked_too(tmp_path: Path, first: str) -> None:
    arcs = [
        "G2 X20 Y0 I10 J0",  # from a place that the line before it may have missed
        "G3 X40 Y0 I7 J0", "G2 X60 Y0 I10 J0 R10", "G2 X80 Y0", "G2 X90 Y0 I5 J0 K2",
        "G1 X0 Y0", "G2 X20 Y0 R4", "G2 X40 Y0 I10 J0",
    ]  # fmt: skip
    with pytest.raises(ConfigError) as error:
        drawn(tmp_path, HEAD + "\n".join([first, *arcs]))
    lines = [int(one.split("part.nc:")[1].split(":")[0]) for one in error.value.args]
    assert lines == [4, 6, 7, 8, 9, 11]


def test_settings_of_a_line_with_a_mistake_hold_behind_it(tmp_path: Path) -> None:
    with pytest.raises(ConfigError) as error:
        drawn(tmp_path, f"{HEAD}G1 X5\nG91 Q1\nG2 X10 Y0 I5 J0\nG2 X10 Y0 I5 J0\n")
    assert len(error.value.args) == 1


@pytest.mark.parametrize(
    ("skip", "codes"),
    [
        (["G1"], []), (["x"], []), (["G92"], []), ([], ["M3"]), ([], ["M3=lamp on"]),
        ([], ["M104=fan on"]), ([], ["G28=1 2"]), ([], ["G28=a b c"]), ([], ["G1=0 0 0"]),
        ([], ["G4=h"]), ([], ["M3=maybe"]), (["G28"], ["G28=0 0 0"]),
    ],
)  # fmt: skip
def test_meanings_that_no_code_has_are_refused(skip: list[str], codes: list[str]) -> None:
    with pytest.raises(ConfigError, match=r"--(skip|code)"):
        meanings_of(skip, codes, OUTPUTS)


@pytest.mark.parametrize(
    ("text", "codes", "seconds"),
    [
        ("G4 P1500", [], 1.5), ("G4 P2", ["G4=s"], 2.0), ("G4 P0.5", [], 0.5),
        ("G4 P0.5\nG4 P2", [], 2.5), ("G4 P500.0", ["G4=ms"], 0.5),
    ],
)  # fmt: skip
def test_the_unit_of_p_is_what_is_said_or_what_a_fraction_shows(
    tmp_path: Path, text: str, codes: list[str], seconds: float
) -> None:
    found = drawn(tmp_path, f"{HEAD}{text}\nX5\n", codes=codes)
    assert found.legs[0]["dwell_s"] == pytest.approx(seconds)
    assert any("G4 P taken as" in note for note in found.notes) is not bool(codes)


@pytest.mark.parametrize(
    ("radius", "apart", "fits"),
    [
        (0.5, 0.9, False), (0.5, 0.02, True), (0.5, 0.04, False), (100, 0.09, True),
        (100, 0.2, False), (300, 0.25, True), (900, 0.6, False),
    ],
)  # fmt: skip
def test_the_radii_of_an_arc_agree_as_linuxcnc_and_grbl_want_it(
    tmp_path: Path, radius: float, apart: float, fits: bool
) -> None:
    text = f"G0 X0 Y0 Z0\nG2 X{2 * radius + apart:g} Y0 I{radius:g} J0\n"
    if fits:
        assert len(drawn(tmp_path, text).legs) == 1
    else:
        with pytest.raises(ConfigError, match=r"nc:2: an arc's radius"):
            drawn(tmp_path, text)


@pytest.mark.study
def test_a_file_of_too_many_moves_is_refused_where_the_first_of_them_is(tmp_path: Path) -> None:
    text = "G0 X0 Y0 Z0\n" + "X1\nX2\n" * 50_000 + "X1\nnever read\n" * 100_000
    with pytest.raises(ConfigError, match=r"nc:100002: is move 100,001"):
        drawn(tmp_path, text)
