"""All charts of a page as one Bokeh document: what they share, what the page may weigh."""

from __future__ import annotations

import html
import itertools
import json
import re
from collections.abc import Iterable, Sequence
from functools import cache
from importlib.resources import files
from importlib.util import find_spec
from typing import Any

import bokeh
import numpy as np
from bokeh.document import Document

from deltactl.charts import drawing, strips
from deltactl.charts.spec import keep, pack, script_json, unpack
from deltactl.foundation.extras import how_to_install

MAXIMUM_BYTES = 520_000
"""Of numbers in a page: with Bokeh's core and the text it stays under 2 MB."""
BYTES_A_NUMBER = 4 * 4 / 3
"""Single precision as base64."""
FEWEST_POINTS = 400


def document(specs: Sequence[dict[str, Any]]) -> tuple[str, bool]:
    """What the page's script needs to draw these charts, as JSON, and whether points were
    left out to keep the page small. Each chart goes to the element that its `id` names.
    """
    thinned = _fit(specs)
    _homes(specs)
    drawn, shared, items = Document(), drawing.Shared(), dict[str, str]()
    with drawn.models.freeze():  # references are gathered once, not at each chart
        for spec in specs:
            draw = strips.strip if spec["kind"] == "heat" else drawing.curves
            plot = draw(spec, spec["height"], shared)
            drawn.add_root(plot)
            items[plot.id] = spec["id"]
    name = "charts"
    render = [{"docid": name, "roots": items, "root_ids": list(items)}]
    text = script_json({"docs": {name: drawn.to_json(deferred=False)}, "items": render})
    return _numbered(text), thinned


def _numbered(text: str) -> str:
    """Models numbered from 1: the same charts give the same page, whatever was drawn before."""
    names: dict[str, str] = {}
    for found in re.finditer(r'"id":"(p\d+)"', text):
        names.setdefault(found[1], f"p{len(names) + 1}")
    return re.sub(r'"(p\d+)"(?=[],}:])', lambda found: f'"{names.get(found[1], found[1])}"', text)


@cache
def library() -> str:
    """Bokeh's core, to stand in the page itself."""
    script = files(bokeh) / "server" / "static" / "js" / "bokeh.min.js"
    text = script.read_text(encoding="utf-8")
    return re.sub(r"//# sourceMappingURL=\S+", "", text)


def _homes(specs: Sequence[dict[str, Any]]) -> None:
    """What each x axis shows at first; in a group, all that any of its charts has."""
    groups: dict[str, tuple[float, float]] = {}
    for spec in specs:
        low, high = (strips if spec["kind"] == "heat" else drawing).home(spec)
        spec["home"] = low, high
        before = groups.get(spec["group"], (low, high))
        groups[spec["group"]] = min(low, before[0]), max(high, before[1])
    for spec in specs:
        if spec["group"]:
            spec["home"] = groups[spec["group"]]


def _fit(specs: Sequence[dict[str, Any]]) -> bool:
    """Thin the longest series until all fit; whether any lost points."""
    series = list(itertools.chain.from_iterable(spec.get("series", ()) for spec in specs))
    sizes = np.array([len(curve["y"]["f32"]) for curve in series], dtype=np.float64)
    columns = np.array([2 + 2 * ("low" in curve) for curve in series])
    most = _longest(sizes, columns)
    points = int(most / BYTES_A_NUMBER)
    for curve, size in zip(series, sizes, strict=True):
        if size > most:
            x, y = unpack(curve["x"]), unpack(curve["y"])
            kept = keep(x, y, max(points, FEWEST_POINTS))
            for name in ("x", "y", "low", "high"):
                if name in curve:
                    curve[name] = pack(unpack(curve[name])[kept])
    return bool((sizes > most).any())


def _longest(sizes: Any, columns: Any) -> float:
    """How many bytes a column may have, that all together stay below the maximum."""
    low, high = 0.0, float(sizes.max(initial=0.0))
    if float((sizes * columns).sum()) <= MAXIMUM_BYTES:
        return high
    for _ in range(30):
        middle = (low + high) / 2
        fits = float((np.minimum(sizes, middle) * columns).sum()) <= MAXIMUM_BYTES
        low, high = (middle, high) if fits else (low, middle)
    return low


_NO_NETWORK = (
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:"
)
"""The browser itself is told that the page may load nothing."""

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
