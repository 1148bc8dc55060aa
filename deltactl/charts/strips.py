"""A heat strip's data, drawn with Bokeh: one row of coloured cells above the other."""

from __future__ import annotations

from typing import Any

import numpy as np
from bokeh.models import (
    ColumnDataSource,
    FixedTicker,
    HoverTool,
    LinearColorMapper,
    Plot,
    Quad,
    Range1d,
)
from bokeh.models.annotations import ColorBar

from deltactl.charts.drawing import Shared, frame, numbers
from deltactl.charts.spec import unpack

RAMP = ("#ffe9a8", "#fac86e", "#f09a55", "#e26e3c", "#c24a43", "#9e1e46", "#6e1442", "#3c0a3c")
"""Steadily darker; distinguishable on white and on black paper, and by the colour-blind."""


def strip(spec: dict[str, Any], height_px: int, shared: Shared) -> Plot:
    """A `HeatStrip`. Its worst states are drawn last: one bad sample is not painted over."""
    spec["yLabel"] = ""
    plot = frame(spec, height_px, shared)
    rows = spec["rows"]
    plot.y_range = Range1d(start=len(rows), end=0)
    plot.window_axis = "none"
    names: Any = plot.left[0]
    names.ticker = FixedTicker(ticks=[row + 0.5 for row in range(len(rows))])
    names.major_label_overrides = {row + 0.5: name for row, name in enumerate(rows)}
    names.major_tick_line_color = None
    lines: Any = plot.center[1]
    lines.visible = False
    states = spec["states"] or [None]
    for number, state in enumerate(states):
        source = _cells(spec["cells"], number if state else None)
        quad = Quad(left="left", right="right", top="top", bottom="bottom", line_width=1)
        if state is None:
            ramp = LinearColorMapper(palette=RAMP, low=spec["low"], high=spec["high"])
            quad.fill_color = quad.line_color = {"field": "value", "transform": ramp}
            plot.add_layout(ColorBar(color_mapper=ramp, title=spec["unit"], height=12), "above")
        renderer = plot.add_glyph(source, quad)
        renderer.name, renderer.tags = f"{number}", [state["colour"]] if state else []
        said = state["name"] if state else f"@value {spec['unit']}"
        tooltips = [(spec["xLabel"], "@left{0.[000]} to @right{0.[000]}"), ("", said)]
        plot.add_tools(HoverTool(renderers=[renderer], tooltips=tooltips, visible=False))
    return plot


def home(spec: dict[str, Any]) -> tuple[float, float]:
    """What the x axis shows at first: all of it."""
    starts = np.concatenate([unpack(row["start"]) for row in spec["cells"]] or [np.zeros(0)])
    ends = np.concatenate([unpack(row["end"]) for row in spec["cells"]] or [np.zeros(0)])
    if not len(starts):
        return 0.0, 1.0
    return float(starts.min()), float(ends.max())


def _cells(cells: list[dict[str, Any]], state: int | None) -> ColumnDataSource:
    """The cells of one state, or all that hold a value."""
    parts: dict[str, list[Any]] = {name: [] for name in ("left", "right", "top", "bottom", "value")}
    for row, cell in enumerate(cells):
        value = unpack(cell["value"])
        chosen = np.isfinite(value) if state is None else np.round(value) == state
        top = np.full(int(chosen.sum()), row + 0.08)
        parts["left"].append(numbers(cell["start"])[chosen])
        parts["right"].append(numbers(cell["end"])[chosen])
        parts["top"].append(top)
        parts["bottom"].append(top + 0.84)
        parts["value"].append(value[chosen])
    return ColumnDataSource({name: np.concatenate(part) for name, part in parts.items()})
