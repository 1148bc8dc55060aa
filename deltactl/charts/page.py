"""The HTML of every report: one file that loads nothing from elsewhere, charts included."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Iterable, Sequence
from functools import cache
from importlib.resources import files
from importlib.util import find_spec
from typing import Any

from deltactl.foundation.extras import how_to_install
from deltactl.foundation.release import own_version

_NO_NETWORK = (
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:"
)
"""Policy for the browser: the page may load nothing."""

HINT = (
    "Drag across a chart to zoom in, the round arrow above it shows everything again; the wheel "
    "zooms while Ctrl is held, two fingers do on a touch screen. Click a name to hide its curve; "
    "PNG, SVG and CSV save what a chart shows and its numbers."
)

THINNED = "Long curves are drawn with fewer points, so that this page stays small; peaks are kept."

_DATA = re.compile(r'<script type="application/json">(.*?)</script>', re.DOTALL)
"""The data of a chart, as `charts.figures.figure` writes it; no text in it can hold a `<`."""


@cache
def style() -> str:
    """The style sheet of every report."""
    return (files("deltactl.charts") / "assets" / "report.css").read_text(encoding="utf-8")


@cache
def script() -> str:
    """What the page does with the library."""
    return (files("deltactl.charts") / "assets" / "charts.js").read_text(encoding="utf-8")


def _drawn(body: str) -> tuple[str, str]:
    """The body with a place for each chart, and the scripts that fill them."""
    specs: list[dict[str, Any]] = [json.loads(found[1]) for found in _DATA.finditer(body)]
    if not specs:
        return body, ""
    if find_spec("bokeh") is None:
        without = f"Not drawn: that needs Bokeh; type {how_to_install('charts')}."
        return _DATA.sub(lambda _: paragraph(without, "note"), body), ""
    from deltactl.charts.document import document, library

    for number, spec in enumerate(specs, 1):
        spec["id"] = f"chart-{number}"
    data, thinned = document(specs)
    places = iter(specs)

    def place(_: re.Match[str]) -> str:
        spec = next(places)
        return f'<div class="plot" id="{spec["id"]}" style="min-height:{spec["height"]}px"></div>'

    body = _DATA.sub(place, body)
    if thinned:
        body += paragraph(THINNED, "note")
    scripts = (
        f'<script type="application/json" id="drawn">{data}</script>\n'
        f"<script>{library()}</script>\n<script>{script()}</script>"
    )
    return body, scripts


def page(title: str, parts: Iterable[str], lead: str = "", extra_style: str = "") -> str:
    """A complete HTML document. `parts` are pieces of HTML, `title` and `lead` plain text.

    `extra_style` is CSS of the caller's own, after the common one.
    """
    body, scripted = _drawn("\n".join(parts))
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f'<meta name="generator" content="deltactl {html.escape(own_version())}">\n'
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
    """A paragraph; kind '', 'note' (small), 'howto' (not printed) or 'warn' (to be seen)."""
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


def unfolds(summary: str, parts: Iterable[str]) -> str:
    """Pieces that open on a click."""
    return f"<details><summary>{html.escape(summary)}</summary>{''.join(parts)}</details>"


def folded(summary: str, text: str) -> str:
    """A long text that opens on a click."""
    return (
        f"<details><summary>{html.escape(summary)}</summary>"
        f"<pre>{html.escape(text)}</pre></details>"
    )
