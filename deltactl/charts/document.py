"""All charts of a page as one Bokeh document: what they share, what the page may weigh.

Loads Bokeh, which a Raspberry Pi need not have: only a page with charts imports this.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence
from functools import cache
from importlib.resources import files
from typing import Any

import bokeh
import numpy as np
from bokeh.document import Document

from deltactl.charts import drawing, strips
from deltactl.charts.spec import keep, pack, script_json, unpack

MAXIMUM_BYTES = 520_000
"""Bytes of the numbers in a page: with Bokeh's core and the text it stays under 2 MB."""
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
    """Bokeh's core, embedded in the page."""
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
