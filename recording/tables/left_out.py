"""Lines of a table that are none of its rows: comments in between, and one of text at the end."""

from __future__ import annotations

from collections.abc import Sequence

from recording.tables.cell import number
from recording.tables.moment import is_moment

COMMENTS = ("#", "%", "//", ";")
"""How a comment begins; the last only where no number follows it, as it may separate cells."""
_MOST_SHOWN = 40
Row = tuple[int, str, list[str]]
"""Number of the line, its text, and its cells."""


def without_remarks(rows: Sequence[Row], width: int, decimal: str) -> tuple[list[Row], str]:
    """Rows without comments and without a last line of text, and words for what was left out;
    empty words where nothing was.
    """
    kept = [row for row in rows if not _is_comment(row, width, decimal)]
    comments, footer = len(rows) - len(kept), ""
    if len(kept) > 1 and _is_footer(kept[-1], width, decimal):
        footer = kept.pop()[1].strip()[:_MOST_SHOWN]
    lines = "one comment line" if comments == 1 else f"{comments} comment lines"
    parts = ([lines] if comments else []) + ([f"the last line ('{footer}')"] if footer else [])
    return kept, f"without {' and '.join(parts)}" if parts else ""


def _is_comment(row: Row, width: int, decimal: str) -> bool:
    _, text, cells = row
    if not text.lstrip().startswith(COMMENTS):
        return False
    return len(cells) != width or not _numbers(cells, decimal)


def _is_footer(row: Row, width: int, decimal: str) -> bool:
    """Whether a line begins with a word and is no row; one cut off begins with a number."""
    _, _, cells = row
    begins = not cells[0] or is_moment(cells[0]) or number(cells[0], decimal) is not None
    return not begins and (len(cells) != width or not _numbers(cells, decimal))


def _numbers(cells: Sequence[str], decimal: str) -> int:
    return sum(number(cell, decimal) is not None or is_moment(cell) for cell in cells)
