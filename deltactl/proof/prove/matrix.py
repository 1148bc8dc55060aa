"""The confusion matrix: what was concealed against what was said first, and its picture."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from xml.sax.saxutils import escape

from deltactl.proof.prove.score import NOTHING, Score

CELL, LEFT, TOP, RIGHT = 26, 190, 190, 110
WRONG_PLACE = "right effect, wrong place"
GROUPS = ("nothing", "single", "faint", "tolerance", "unknown", "seen", "unseen")
"""Groups with one answer at most; several effects have no single cell."""
Matrix = dict[tuple[str, str], int]


def confusion(scores: Sequence[Score]) -> Matrix:
    """(concealed, said first) -> cases. An unknown kind is a row of its own."""
    cells: Counter[tuple[str, str]] = Counter()
    for marks in scores:
        if marks.group not in GROUPS:
            continue
        row = NOTHING
        if marks.truth:
            row = f"unknown: {marks.kind}" if marks.truth[0][0] == "unknown" else marks.truth[0][0]
        cells[row, _said(marks)] += 1
    return dict(cells)


def _said(marks: Score) -> str:
    if marks.failure is not None:
        return "failed"
    if not marks.said:
        return NOTHING
    effect = marks.said[0][0]
    same = bool(marks.truth) and effect == marks.truth[0][0] != "unknown"
    return WRONG_PLACE if same and marks.said[0] != marks.truth[0] else effect


def rows_and_columns(cells: Matrix) -> tuple[list[str], list[str]]:
    """Names in an order that puts right answers on the diagonal."""
    rows = sorted({row for row, _ in cells}, key=lambda name: (name.startswith("unknown"), name))
    plain = [name for name in rows if not name.startswith("unknown")]
    said = {column for _, column in cells}
    extra = sorted(said - set(plain) - {"unknown"})
    columns = [name for name in plain if name in said or name != NOTHING]
    return rows, [*columns, *extra, *(["unknown"] if "unknown" in said else [])]


def picture(cells: Matrix, title: str) -> str:
    """The matrix as an SVG drawing."""
    rows, columns = rows_and_columns(cells)
    width, height = LEFT + CELL * len(columns) + RIGHT, TOP + CELL * len(rows) + 20
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
        'font-family="sans-serif" font-size="12">',
        f'<rect width="{width}" height="{height}" fill="#ffffff"/>',
        f'<text x="10" y="20" font-size="13">{escape(title)}</text>',
        f'<text x="10" y="{TOP - 10}" fill="#555555">concealed, down; said first, across</text>',
    ]
    for j, name in enumerate(columns):
        x = LEFT + CELL * j + CELL // 2 + 4
        parts.append(
            f'<text transform="translate({x},{TOP - 8}) rotate(-60)">{escape(name)}</text>'
        )
    for i, row in enumerate(rows):
        y = TOP + CELL * i
        total = sum(count for (name, _), count in cells.items() if name == row)
        parts.append(f'<text x="{LEFT - 8}" y="{y + 17}" text-anchor="end">{escape(row)}</text>')
        for j, column in enumerate(columns):
            parts.append(_cell(LEFT + CELL * j, y, cells.get((row, column), 0), total, row, column))
    return "\n".join([*parts, "</svg>"]) + "\n"


def _cell(x: int, y: int, count: int, total: int, row: str, column: str) -> str:
    right = row == column or (row.startswith("unknown") and column == "unknown")
    red, green, blue = (30, 110, 60) if right else (170, 50, 40)
    shade = count / total if total else 0.0
    colour = "#{:02x}{:02x}{:02x}".format(
        *(round(255 - shade * (255 - channel)) for channel in (red, green, blue))
    )
    ink = "#ffffff" if shade > 0.5 else "#222222"
    box = f'<rect x="{x}" y="{y}" width="{CELL}" height="{CELL}" fill="{colour}" stroke="#dddddd"/>'
    if not count:
        return box
    return f'{box}<text x="{x + 13}" y="{y + 17}" text-anchor="middle" fill="{ink}">{count}</text>'
