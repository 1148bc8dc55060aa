"""The shares of a table as one drawing: a line a figure, a mark with its 95 % limits a tool."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from xml.sax.saxutils import escape

SHARE = re.compile(r"(\d+) of (\d+) \[([\d.]+), ([\d.]+)\]")
COLOURS = {
    "deltactl": "#1b6e3c",
    "lmfit": "#2a6f97",
    "PySINDy": "#b5651d",
    "textbook": "#7a4fa3",
    "Klipper": "#a33c3c",
    "FIGAROH": "#c2185b",
    "sysid, true set": "#555555",
    "sysid, all": "#999999",
}
"""Always the same colour for a tool, in whatever groups it is."""
LEFT, WIDTH, TOP, LINE, GAP = 260, 300, 46, 11, 9
BRIEF = ("names right,", "false claims")
"""Beginnings of the figures in the small drawing."""


def drawing(tables: Sequence[Mapping[str, Mapping[str, str]]], brief: bool = False) -> str:
    """An SVG of every share in tables tool -> figure -> text; brief: names and claims alone.

    Higher is better, but for claims, which say so.
    """
    parts: list[str] = []
    y = TOP
    for figure, own in chain.from_iterable(map(_shares, tables)):
        if brief and not figure.startswith(BRIEF):
            continue
        title = figure.replace(" on healthy machines", "")
        title += " (less is better)" if figure.startswith("false") else ""
        middle = y + LINE * len(own) // 2
        parts.append(f'<text x="{LEFT - 10}" y="{middle}" text-anchor="end">{title}</text>')
        for tool, found in own:
            parts.append(_mark(y, tool, found))
            y += LINE
        y += GAP
    height = y + 10
    grid = [
        f'<path d="M{LEFT + WIDTH * share:.0f} {TOP - 8}V{y}" stroke="#ddd"/>'
        f'<text x="{LEFT + WIDTH * share:.0f}" y="{TOP - 12}" text-anchor="middle">{share:g}</text>'
        for share in (0.0, 0.5, 1.0)
    ]
    tools = list(dict.fromkeys(tool for columns in tables for tool in columns))
    legend = "".join(
        f'<text x="{10 + 105 * place}" y="14" fill="{COLOURS[tool]}">● {escape(tool)}</text>'
        for place, tool in enumerate(tools)
    )
    width = max(LEFT + WIDTH + 70, 20 + 105 * len(tools))
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
        f'font-family="sans-serif" font-size="10"><rect width="{width}" height="{height}" '
        'fill="#ffffff"/>'
    )
    return "\n".join([head, legend, *grid, *parts, "</svg>"]) + "\n"


def _shares(
    columns: Mapping[str, Mapping[str, str]],
) -> Iterator[tuple[str, list[tuple[str, re.Match[str]]]]]:
    """Figures of a table, each with the tools that have a share of it."""
    for figure in dict.fromkeys(name for rows in columns.values() for name in rows):
        marks = [(tool, SHARE.match(rows.get(figure, ""))) for tool, rows in columns.items()]
        if own := [(tool, found) for tool, found in marks if found is not None]:
            yield figure, own


def _mark(y: int, tool: str, found: re.Match[str]) -> str:
    hits, cases = int(found[1]), int(found[2])
    low, high, at = (LEFT + WIDTH * x for x in (float(found[3]), float(found[4]), hits / cases))
    colour = COLOURS[tool]
    return (
        f'<path d="M{low:.1f} {y}H{high:.1f}" stroke="{colour}"/>'
        f'<circle cx="{at:.1f}" cy="{y}" r="3.5" fill="{colour}"/>'
        f'<text x="{LEFT + WIDTH + 12}" y="{y + 4}" fill="{colour}">{hits} of {cases}</text>'
    )
