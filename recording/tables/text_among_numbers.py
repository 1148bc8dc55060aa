"""Cells of text in columns of numbers: they are read as empty, and are told."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from foundation.counting import count
from recording.tables.cell import is_number

MOSTLY = 0.5
"""Share of numbers from which on a column is one of numbers, and its text a mistake."""
MISSING = frozenset({"nan", "na", "n/a", "null", "none", "nil", "inf", "+inf", "-inf", "-", "--"})
"""What logs write where there is no reading."""
MOST_SHOWN = 20


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
            f"line {line}: {cell[:MOST_SHOWN]!r} in column '{name}' is no number and is read as no"
            f" reading{more}"
        )
