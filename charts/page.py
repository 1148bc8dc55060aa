"""A whole report as one HTML file: text, tables, charts; nothing is fetched from anywhere."""

from __future__ import annotations

import html
from collections.abc import Iterable, Sequence
from functools import cache
from importlib.resources import files

_NO_NETWORK = (
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:"
)
"""The browser itself is told that the page may load nothing."""

HINT = (
    "Drag across a chart to zoom in, double-click to see everything again; Shift and drag moves. "
    "The wheel zooms while Ctrl is held or after a click on the chart; on a touch screen use two "
    "fingers. Click a name to hide its curve."
)


@cache
def style() -> str:
    """The style sheet of every report."""
    return (files("charts") / "assets" / "report.css").read_text(encoding="utf-8")


@cache
def script() -> str:
    """The script of every report: the parts in the order of their names, in one scope."""
    parts = sorted(
        (part for part in (files("charts") / "assets").iterdir() if part.name.endswith(".js")),
        key=lambda part: part.name,
    )
    body = "\n".join(part.read_text(encoding="utf-8") for part in parts)
    return f'(() => {{\n"use strict";\n{body}\n}})();'


def page(title: str, parts: Iterable[str], lead: str = "", extra_style: str = "") -> str:
    """A complete HTML document. `parts` are pieces of HTML, `title` and `lead` plain text.

    `extra_style` is CSS of the caller's own, after the common one.
    """
    body = "\n".join(parts)
    scripted = f"<script>{script()}</script>" if '<figure class="chart">' in body else ""
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{_NO_NETWORK}">\n'
        f"<title>{html.escape(title)}</title>\n<style>{style()}{extra_style}</style></head>\n<body>\n"
        f"<h1>{html.escape(title)}</h1>\n"
        + (f'<p class="lead">{html.escape(lead)}</p>\n' if lead else "")
        + "<noscript><p class=warn>The charts need JavaScript, which is switched off here.</p>"
        f"</noscript>\n{body}\n{scripted}</body></html>\n"
    )


def heading(text: str) -> str:
    """A section heading."""
    return f"<h2>{html.escape(text)}</h2>"


def paragraph(text: str, kind: str = "") -> str:
    """A paragraph; kind '' , 'note' (small) or 'warn' (not to be overlooked)."""
    mark = f' class="{kind}"' if kind else ""
    return f"<p{mark}>{html.escape(text)}</p>"


def table(
    head: Sequence[str], rows: Iterable[Sequence[str]], numbers_from: int = 1, caption: str = ""
) -> str:
    """A table; columns from `numbers_from` on are set as numbers (use a large one for none)."""

    def cell(tag: str, column: int, text: str) -> str:
        mark = ' class="number"' if column >= numbers_from else ""
        return f"<{tag}{mark}>{html.escape(text)}</{tag}>"

    def line(tag: str, row: Sequence[str]) -> str:
        return f"<tr>{''.join(cell(tag, k, text) for k, text in enumerate(row))}</tr>"

    title = f"<caption>{html.escape(caption)}</caption>" if caption else ""
    body = "".join(line("td", row) for row in rows)
    top = f"<thead>{line('th', head)}</thead>" if head else ""
    return f'<div class="wide"><table>{title}{top}<tbody>{body}</tbody></table></div>'


def facts(rows: Iterable[tuple[str, str]]) -> str:
    """A table of names and values without a heading."""
    return table((), list(rows), numbers_from=99).replace("<table>", '<table class="facts">', 1)


def columns(parts: Iterable[str]) -> str:
    """Pieces side by side where there is room, one below the other on a phone."""
    cells = "".join(f"<div>{part}</div>" for part in parts)
    return f'<div class="columns">{cells}</div>'


def folded(summary: str, text: str) -> str:
    """A long text that opens on a click."""
    return (
        f"<details><summary>{html.escape(summary)}</summary>"
        f"<pre>{html.escape(text)}</pre></details>"
    )
