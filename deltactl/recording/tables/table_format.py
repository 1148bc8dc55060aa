"""How a table of somebody else is written: separator, decimal mark, lines before the heading."""

from __future__ import annotations

import csv
import io
import itertools
import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from deltactl.foundation.errors import RecordingError
from deltactl.recording.tables.cells import is_date, is_moment, is_number, is_time_of_day
from deltactl.recording.tables.csv_table import read_text

WIDE = "  "
"""Two spaces or more: one alone is part of a cell, as in a date with its time."""
SEPARATORS = {
    ",": "commas",
    ";": "semicolons",
    "\t": "tabs",
    "|": "bars",
    " ": "spaces",
    WIDE: "several spaces",
}
"""Sought in this order; a space means any run of spaces and tabs."""
IN_OPTIONS = {"\t": "tab", " ": "space", WIDE: "spaces", ",": "comma", ";": "semicolon"}
"""What a shell or an eye would lose, as it is typed after `separator=`."""
_STAMP_UNIT = re.compile(r"(?i)time *[\[(](n?s|[mu]s)[\])]")
"""A key whose value is a time, with its unit, as SampleTime[ms]."""
MANY_LINES = 400
UNIT_CELL = re.compile(
    r"[\[(]?(°|[numkcM]?(s|m|rad|A|V|N|Nm|N\.m|Hz)(/s)?|deg(/s)?|arcsec|arcmin|turn|min|1|-|%)?[\])]?"
)
_STAMPED = re.compile(r"^(\d\d:\d\d:\d\d[.,]\d+) -> ")
"""What a serial monitor puts before each line."""
_LABELLED = re.compile(r"([A-Za-z_][\w .]*?)\s*:\s*([-+]?[.\d]\S*)")
"""What a serial plotter takes: each value with its name before it, Setpoint:12.5."""
_NUMBERED_NAME = re.compile(
    r"(?i)[#%;/\s]*(?:name|col|column|channel|ch|field|signal)[ _]*(\d+)\s*[:=]\s*(\S.*?)\s*"
)
"""What lists the columns above a table, as in # NAME0 = Target Position of axis 1."""
_WORD = re.compile(r"(?<!\S)[^\W\d_]{2,}(?=[\s.,:;!?]|$)")
_PROSE = 3
"""Words to a line from which on a file is one of sentences."""
_MOST_SHOWN = 40
_NUMBER = r"[\s:=,;\[(]+([a-zµ]*)[\s:=,;\])]*(\d+(?:[.,]\d+)?(?:e[-+]?\d+)?)\s*([a-zµ]*)"
_RATE = re.compile(rf"(?i)\b(?:fs|sampl\w*[ _]?(?:rate|frequency|freq))\b{_NUMBER}")
_PERIOD = re.compile(rf"(?i)\b(?:sampl\w*[ _]?(?:time|period|interval)|delta_?[tx]|dt)\b{_NUMBER}")
"""What programs call the rows a second, or the time between two, above a table."""
_IN_HZ = {"": 1.0, "hz": 1.0, "khz": 1e3}
_IN_S = {"": 1.0, "s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6}
_WIDE_GAP = re.compile(r" {2,}|[ \t]*\t[ \t]*")


@dataclass(frozen=True, slots=True)
class TableFormat:
    """The lines of the numbers, and the names of their columns.

    names: as the file has them, or column_1, column_2, ... where it has none (`named` is False).
    units: of a line of units under the heading, empty texts without one. heading_line: of the
    heading, counted from 0; None where `names` must be given to whoever reads the file.
    """

    separator: str
    decimal: str
    first_row: int
    names: tuple[str, ...]
    named: bool
    units: tuple[str, ...]
    heading_line: int | None
    mark: str
    """How the file's characters are written, as `UTF-8`."""
    before: tuple[str, ...]
    """The lines before all this."""

    @property
    def heading(self) -> tuple[str, ...]:
        """The names that must be given to whoever reads the file; empty where a line has them."""
        return () if self.heading_line is not None else self.names

    @property
    def skip_lines(self) -> int:
        """Lines before the heading, or before the numbers where the names are given."""
        return self.first_row if self.heading_line is None else self.heading_line


def split(line: str, separator: str) -> list[str]:
    """The cells of a line, without quotes, spaces round them, and labels that all of them have."""
    cells = _cells(line, separator)
    labelled = [_LABELLED.fullmatch(cell) for cell in cells]
    values = [one[2] for one in labelled if one]
    return values if len(values) == len(cells) > 1 else cells


def _cells(line: str, separator: str) -> list[str]:
    if stamp := _STAMPED.match(line):
        line = stamp[1] + separator + line[stamp.end() :]
    if separator == " ":
        return line.split()
    if separator == WIDE:
        return _WIDE_GAP.split(line.strip())
    if '"' in line or "\r" in line or not line:
        cells = next(csv.reader(io.StringIO(line), delimiter=separator), [])
    else:  # what csv would give, ten times as fast
        cells = line.split(separator)
    return [cell.strip() for cell in cells]


def guess_format(
    path: Path, separator: str | None = None, decimal: str | None = None
) -> TableFormat:
    """Look at the first lines of a table; separator, decimal: what is known of it already.

    Raises RecordingError where no columns of numbers are.
    """
    lines = _first_lines(path)
    return _heading(path, lines, *_marks(path, lines, separator, decimal))


def guess_marks(
    path: Path, separator: str | None = None, decimal: str | None = None
) -> tuple[str, str]:
    """Separator and decimal mark of a table; either may be known already.

    Raises RecordingError where no columns of numbers are.
    """
    return _marks(path, _first_lines(path), separator, decimal)[:2]


def marks_said(separator: str, decimal: str) -> str:
    """Words for how a table is written, as `tabs between, decimal comma`."""
    point = "decimal comma" if decimal == "," else "decimal point"
    return f"{SEPARATORS.get(separator, repr(separator))} between, {point}"


def rate_said(lines: Iterable[str]) -> tuple[float, str] | None:
    """Rows a second [1/s] that a line above a table says, as `Fs,50.00`, and that line."""
    for line in lines:
        for pattern, in_si, power in ((_RATE, _IN_HZ, 1), (_PERIOD, _IN_S, -1)):
            if (found := pattern.search(line)) is None:
                continue
            unit = (found[1] or found[3]).lower()
            size = float(found[2].replace(",", ".")) * in_si.get(unit, 0.0)
            if size > 0.0:
                return size**power, line.strip()
    return None


def first_cells(path: Path) -> list[str]:
    """The cells of the first line between commas. Raises RecordingError for what is no text."""
    return split(_first_lines(path)[0], ",")


def _first_lines(path: Path) -> list[str]:
    return read_text(path, any_encoding=True).split("\n")[:MANY_LINES]


def _marks(
    path: Path, lines: list[str], separator: str | None, decimal: str | None
) -> tuple[str, str, int]:
    """Separator, decimal mark and usual number of cells that suit the lines best."""
    lines = [line for line in lines if line.strip()]
    best: _Suits | None = None
    for between in SEPARATORS if separator is None else (separator,):
        split_up = [split(line, between) for line in lines]
        for point in (".", ",") if decimal is None else (decimal,):
            suits = _suits(lines, split_up, between, point)
            if best is None or suits > best:
                best, found = suits, (between, point)
    if best is None or best.numbers == 0.0:
        raise RecordingError(f"{path}: no columns of numbers were found in it; {_needed(lines)}")
    return *found, best.width


def _needed(lines: list[str]) -> str:
    """What a table is, for who gave something else; lines: those that are not empty."""
    table = (
        "a table has a line of numbers for each reading or point, with commas, semicolons, tabs or"
        " spaces between them (CSV), below a line that names the columns"
    )
    if not lines:
        return f"it is empty; {table}"
    words = [len(_WORD.findall(line)) for line in lines]
    if sum(words) < _PROSE * len(lines):
        return table
    return f"it looks like text ('{lines[0].strip()[:_MOST_SHOWN]}'); {table}"


class _Suits(NamedTuple):
    """How well a separator and a decimal mark suit a table; what comes first decides."""

    numbers: float
    """Share of the cells that are numbers or times, in lines of the usual width."""
    steady: float
    """Share of the lines that have this width."""
    headed: bool
    """Whether the line above has as many words; of one column any line would."""
    whole: bool
    """Whether no day is separate from its time, as where the blank between them separates."""
    width: int


def _suits(lines: list[str], split_up: list[list[str]], separator: str, decimal: str) -> _Suits:
    """How well they suit lines that are split up by this separator already."""
    right = [_good(row, decimal) for row in split_up]
    places = [n for n, row in enumerate(split_up) if any(row) and 2 * right[n] > len(row)]
    if not places:
        return _Suits(0.0, 0.0, False, False, 0)
    width, _ = Counter(len(split_up[n]) for n in places).most_common(1)[0]
    usual = [n for n in places if len(split_up[n]) == width]
    good, first = sum(right[n] for n in usual), split_up[usual[0]]
    above = _words(lines[usual[0] - 1], separator) if usual[0] else []
    return _Suits(
        round(good / (width * len(usual)), 2),
        round(len(usual) / len(lines), 2),
        len(above) == width > 1,
        not any(is_date(a) and is_time_of_day(b) for a, b in itertools.pairwise(first)),
        width,
    )


def _good(row: list[str], decimal: str) -> int:
    return sum(is_number(cell, decimal) or is_moment(cell) for cell in row)


def _heading(path: Path, lines: list[str], separator: str, decimal: str, width: int) -> TableFormat:
    """The columns of a table of so many cells to a line, from what is above its numbers."""
    rows = (n for n, line in enumerate(lines) if _is_row(split(line, separator), decimal, width))
    first = next(rows, None)
    if first is None:
        raise RecordingError(f"{path}: no line with {width} numbers was found in its first lines")
    plain = "UTF-8" if _is_utf8(path) else "cp1252"
    if (keyed := _keyed(lines[:first], separator, width)) is not None:
        before = tuple(filter(str.strip, lines[:first]))
        return TableFormat(separator, decimal, first, keyed[0], True, keyed[1], None, plain, before)
    above, units = _above(lines[:first], separator, width)
    names, heading = _labels(lines[first], separator) or _listed(lines[:first], width), None
    if above and not names:
        names, heading = _of_a_line(lines[:first], above[-1], separator)
    numbers = tuple(f"column_{n + 1}" for n in range(width))
    before = tuple(line for line in lines[: above[-1] if above else first] if line.strip())
    return TableFormat(
        separator, decimal, first, names or numbers, bool(names), units, heading, plain, before
    )


def _of_a_line(lines: list[str], n: int, separator: str) -> tuple[tuple[str, ...], int | None]:
    """The names in line n, and n where it is a heading just above the numbers; else something is
    between, and the reader must be given the names.
    """
    is_heading = n + 1 == len(lines) and lines[n].lstrip()[:1] not in "#%"
    return tuple(_words(lines[n], separator)), n if is_heading else None


def _listed(lines: list[str], width: int) -> tuple[str, ...]:
    """The names of columns that lines above them list by numbers, each in a line of its own."""
    found = [listed for line in lines if (listed := _NUMBERED_NAME.fullmatch(line))]
    names = {int(listed[1]): listed[2] for listed in found}
    one_by_one = len(names) == width and max(names) - min(names) == width - 1
    distinct = len({*names.values()}) == width
    return tuple(names[n] for n in sorted(names)) if one_by_one and distinct else ()


def _keyed(
    lines: list[str], separator: str, width: int
) -> tuple[tuple[str, ...], tuple[str, ...]] | None:
    """Names and units of columns of which every second has the times of the next, where the lines
    above them repeat a key before each value, as in exports of TwinCAT Scope; else None.
    """
    keys = _values_by_key([_words(line, separator) for line in lines], width)
    if len(keys) < 2:
        return None
    stamp = next((found[1] for key in keys if (found := _STAMP_UNIT.search(key))), "")
    given = next((values for key, values in keys.items() if key.lower() == "unit"), [""] * width)
    parts = [cell.split() for cell in given]
    units = [part[0] if part and UNIT_CELL.fullmatch(part[0]) else "" for part in parts]
    names = next(iter(keys.values()))
    times = ["time", *(f"time {n}" for n in range(2, len(names) + 1))]
    return (
        tuple(itertools.chain.from_iterable(zip(times, names, strict=True))),
        tuple(one for unit in units[: len(names)] for one in (stamp, unit)),
    )


def _values_by_key(lines: list[list[str]], width: int) -> dict[str, list[str]]:
    """The values of lines that repeat one key before each, by the key."""
    keys: dict[str, list[str]] = {}
    for cells in lines:
        if len(cells) == width > 2 and width % 2 == 0 and len({*cells[::2]}) == 1:
            keys.setdefault(cells[0], cells[1::2])
    return keys


def _above(lines: list[str], separator: str, width: int) -> tuple[list[int], tuple[str, ...]]:
    """The lines above the numbers that may be their heading, and the units below the heading."""
    words = [tuple(_words(line, separator)) for line in lines]
    above = [
        n for n, line in enumerate(lines) if len(words[n]) == width and rate_said([line]) is None
    ]
    if len(above) > 1 and all(map(UNIT_CELL.fullmatch, words[above[-1]])):
        return above[:-1], tuple(cell.strip("[]()") for cell in words[above[-1]])
    return above, ("",) * width


def _is_row(cells: list[str], decimal: str, width: int) -> bool:
    """Whether cells are so many, and most of them numbers."""
    return len(cells) == width and any(cells) and 2 * _good(cells, decimal) > width


def _labels(line: str, separator: str) -> tuple[str, ...]:
    """The names before the values of a line, where each value has one."""
    labels = [_LABELLED.fullmatch(cell) for cell in _cells(line, separator)]
    return tuple(label[1] for label in labels if label) if all(labels) else ()


def _words(line: str, separator: str) -> list[str]:
    return split(line.lstrip("#% \t") if separator != "\t" else line.lstrip("#% "), separator)


def _is_utf8(path: Path) -> bool:
    try:
        read_text(path)
    except RecordingError:
        return False
    return True
