"""The number that a cell of a table holds, and what is said of one that holds none."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

from deltactl.foundation.errors import RecordingError
from deltactl.foundation.printable import count

_MOST_SHOWN = 40
MOSTLY = 0.5
"""Share of numbers from which on a column is one of numbers, and its text a mistake."""
MISSING = frozenset({"nan", "na", "n/a", "null", "none", "nil", "inf", "+inf", "-inf", "-", "--"})
"""What logs write where there is no reading."""


def number(cell: str, decimal: str = ".") -> float | None:
    """The number in a cell; None where it holds none, an empty one included.

    Python's own float() also takes 1_0 for ten, and digits of any script: neither is a number
    here, nor to the programs that write tables.
    """
    plain = cell if decimal == "." else cell.replace(decimal, ".")
    if "_" in plain or not plain.isascii():
        return None
    try:
        return float(plain)
    except ValueError:
        return None


def is_number(cell: str, decimal: str) -> bool:
    """Whether a cell holds a number that is not infinite (or nothing) with this decimal mark."""
    if decimal == "," and "." in cell:
        return False
    value = number(cell, decimal)
    return not cell if value is None else not math.isinf(value)


def not_a_number(path: Path, line: int, name: str, cell: str) -> RecordingError:
    """What is said of a cell that should hold a number; `line` counts from 1."""
    return RecordingError(f"{path}:{line}: {name} must be a number (got {cell[:_MOST_SHOWN]!r})")


def wrong_count(path: Path, line: int, found: int, wanted: int) -> RecordingError:
    """What is said of a row that has more or fewer cells than the heading."""
    cells = {0: "is empty", 1: "has one cell"}.get(found, f"has {found} cells")
    return RecordingError(
        f"{path}:{line}: this row {cells}, the heading has {wanted}; complete or delete the row, or"
        " separate it as the others are"
    )


def text_among_numbers(
    heading: Sequence[str], rows: Sequence[tuple[int, str, Sequence[str]]], decimal: str
) -> Iterator[str]:
    """A sentence for each column (of a heading) in which a few cells are neither number nor empty.

    rows: line in the file from 1, its text, its cells.
    """
    for place, name in enumerate(heading):
        found = [
            (line, cells[place].strip())
            for line, _, cells in rows
            if not is_number(cells[place].strip(), decimal)
        ]
        wrong = [(line, cell) for line, cell in found if cell.lower() not in MISSING]
        if not wrong or len(found) > (1.0 - MOSTLY) * len(rows):
            continue
        line, cell = wrong[0]
        more = f" ({count(len(wrong) - 1, 'more cell')} of it likewise)" if len(wrong) > 1 else ""
        yield (
            f"line {line}: {cell[:_MOST_SHOWN]!r} in column '{name}' is no number and is read as no"
            f" reading{more}"
        )
