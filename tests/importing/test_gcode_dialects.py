"""What programs write, read here and by an independent reader: the moves end at the same places.

The files are written anew as those programs write, each with what is usual there. The other reader
is gcodeparser, with a dozen lines that carry out what it reads; it takes a command to a line, so
that lines of coordinates alone are given their command before, and comments are taken off.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from gcodeparser import parse_gcode_lines
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.firmware_py.importing.gcode import read_gcode
from deltactl.foundation.errors import ConfigError

FILES = sorted((Path(__file__).parent / "dialects").iterdir())
Ends = list[tuple[float, ...]]


def ends_here(path: Path) -> Ends:
    """Places [mm] that the reader of this project gives, each once where it is not left."""
    drawn = read_gcode(path, (0.0, 0.0, 0.0))
    places = [drawn.start_m, *(leg["to_m"] for leg in drawn.legs)]
    return moved([tuple(1e3 * value for value in place) for place in places])


def ends_there(text: str) -> Ends:
    """Places [mm] by gcodeparser, from the first where all three axes are known."""
    plain = re.sub(r"\([^()]*\)|;.*", "", re.sub(r"\([^()]*\)", "", text))
    lines, modal = [], "G0"
    for line in re.split(r"(?m)^[ \t]*[Mm]0*(?:2|30)\b", plain)[0].splitlines():
        line = re.sub(r"^\s*[Nn]\s*\d+", "", line.upper())
        line = re.sub(r"([A-Z])\s+(?=[-+.\d])", r"\1", line)
        line = re.sub(r"G\d+\.\d+", "", line)
        line = re.sub(r"(\d)\.(?!\d)", r"\1", line)
        if re.match(r"\s*[XYZ]", line):
            line = f"{modal} {line}"
        found = re.findall(r"G0*([0-3])(?!\d)", line)
        modal = f"G{found[-1]}" if found else modal
        lines.append(line)
    at: dict[str, float | None] = dict.fromkeys("XYZ")
    if "Z" not in "".join(re.findall(r"Z(?=[-+.\d])", plain.upper())):
        at["Z"] = 0.0
    unit, relative, places = 1.0, False, []
    for one in parse_gcode_lines("\n".join(lines)):
        letter, number = one.command
        if letter != "G":
            continue
        unit = {20: 25.4, 21: 1.0}.get(number, unit)
        relative = {90: False, 91: True}.get(number, relative)
        axes = {axis: one.params[axis] for axis in "XYZ" if axis in one.params}
        if number == 92 or not axes:
            continue
        for axis, value in axes.items():
            at[axis] = float(value) * unit + ((at[axis] or 0.0) if relative else 0.0)
        if all(value is not None for value in at.values()):
            places.append(tuple(value or 0.0 for value in at.values()))
    return moved(places)


def moved(places: Ends) -> Ends:
    """Places without those at which nothing moved."""
    rounded = [tuple(round(value, 4) + 0.0 for value in place) for place in places]
    return [place for n, place in enumerate(rounded) if n == 0 or place != rounded[n - 1]]


def agree(ours: Ends, theirs: Ends) -> None:
    assert len(ours) == len(theirs)
    for own, other in zip(ours, theirs, strict=True):
        assert own == pytest.approx(other, abs=2e-4)


@pytest.mark.parametrize("path", FILES, ids=[path.stem for path in FILES])
def test_the_moves_of_a_program_end_where_another_reader_ends_them(path: Path) -> None:
    ours = ends_here(path)
    assert len(ours) > 5
    agree(ours, ends_there(path.read_text()))


def test_there_are_enough_dialects() -> None:
    assert len(FILES) >= 13


number = st.integers(-90_000, 90_000).map(lambda value: value / 1000)
spelt = st.sampled_from(["{:.3f}", "{:g}", "{:+.3f}", "{:.4f}"])


@st.composite
def programs(draw: st.DrawFn) -> str:
    """A program in one of the ways in which posts write."""
    lower, numbers = draw(st.booleans()), draw(st.booleans())
    between, end = draw(st.sampled_from([" ", "", "  "])), draw(st.sampled_from(["\n", "\r\n"]))
    form, code = draw(spelt), draw(st.sampled_from(["G{}", "G0{}"]))
    comment = draw(st.sampled_from(["", " ; X99", " (Y99)", "(G1 X9)"]))
    unit = draw(st.sampled_from(["G21", "G20"]))
    scale = 1.0 if unit == "G21" else 0.1
    lines = [
        f"{unit}{between}G90{between}G17",
        f"{code.format(0)}{between}X0{between}Y0{between}Z5",
    ]
    for _ in range(draw(st.integers(1, 12))):
        kind = draw(st.sampled_from(["move", "alone", "mode", "m", "modal"]))
        axes = draw(st.lists(st.sampled_from("XYZ"), min_size=1, max_size=3, unique=True))
        words = [f"{axis}{form.format(draw(number) * scale)}" for axis in axes]
        extra = draw(st.sampled_from([[], ["F600"], ["S1000"], ["E0.5"]]))
        if kind == "mode":
            lines.append(draw(st.sampled_from(["G90", "G91"])))
        elif kind == "m":
            lines.append(draw(st.sampled_from(["M205 X8 Y9", "M3 S100", "M107", "M84 X Y"])))
        elif kind == "modal":
            lines.append(f"{code.format(draw(st.sampled_from('01')))}{between}F500")
        elif kind == "alone":
            lines.append(between.join(words))
        else:
            lines.append(between.join([code.format(draw(st.sampled_from("01"))), *words, *extra]))
    if numbers:
        lines = [f"N{10 * n}{between}{line}" for n, line in enumerate(lines, 1)]
    text = end.join(f"{line}{comment}" for line in lines) + end
    return text.lower() if lower else text


@pytest.mark.study
@given(programs())
@settings(max_examples=60, deadline=None)
def test_programs_of_many_spellings_end_where_another_reader_ends_them(
    tmp_path_factory: pytest.TempPathFactory, text: str
) -> None:
    path = tmp_path_factory.getbasetemp() / "spelt.nc"
    path.write_bytes(text.encode())
    theirs = ends_there(text)
    if len(theirs) > 1:
        agree(ends_here(path), theirs)
    else:
        with pytest.raises(ConfigError, match="is the only place in it"):
            ends_here(path)
