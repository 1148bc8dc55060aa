"""A chart's data, drawn with Bokeh: curves, bands, points, columns, spans and marks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from bokeh.models import (
    BasicTickFormatter,
    BoxZoomTool,
    ColumnDataSource,
    CrosshairTool,
    DataRange1d,
    Grid,
    HoverTool,
    Line,
    LinearAxis,
    PanTool,
    Plot,
    Range1d,
    ResetTool,
    Scatter,
    VArea,
    VBar,
    WheelZoomTool,
    ZoomInTool,
    ZoomOutTool,
)
from bokeh.models.annotations import BoxAnnotation, Label, Span, Title
from bokeh.models.css import InlineStyleSheet

from deltactl.charts.spec import FloatArray, unpack

LEFT_PX = 62
"""Room for numbers: charts of a group start at the same place, times are aligned."""
POINTS = ((3000, 2.0, 0.6), (500, 2.4, 0.6), (0, 4.0, 0.85))
"""More points than this: size [px], opacity. Many close together must not hide what is below."""
TALL_PX = 300
NOT_ON_PAPER = "@media print { :host { visibility: hidden; } }"
LETTERS_ACROSS = 140
"""Letters of the labels at marks that fit into the width of a chart."""
ROOM = 0.05
"""Part of the extent left free around the curves of a plane."""
FINE = 1e-5
"""Single precision does where it resolves this part of an axis."""

WRITTEN_OUT = -5
"""Numbers above this power of ten are written out: 0.002, not 2.000e-3."""

Shared = dict[str, tuple[Range1d, Span]]
"""Axis and pointer of each group of charts."""


def frame(spec: dict[str, Any], height_px: int, shared: Shared) -> Plot:
    """An empty chart with axes, grid and tools. Charts of one group share the x axis,
    which shows at first the `home` of the spec.
    """
    group = spec["group"]
    low, high = spec["home"]
    if group not in shared or not group:
        pointer = Span(dimension="height", line_width=1, css_variables=_line("axis"))
        whole = Range1d(start=low, end=high, reset_start=low, reset_end=high)
        shared[group] = (whole, pointer)
    x_range, pointer = shared[group]
    plane = bool(spec.get("equal"))
    plot = Plot(
        x_range=x_range,
        y_range=DataRange1d(only_visible=True, range_padding=0.06),
        window_axis="none" if plane else "x",
        match_aspect=plane,
        height=height_px,
        sizing_mode="stretch_width",
        min_border_left=LEFT_PX,
        min_border_right=12,
        toolbar_location="above",
        title=Title(text="", visible=False),
        name=spec["id"],
    )
    if plane:
        plot.x_range = DataRange1d(only_visible=True, range_padding=ROOM)
        plot.y_range = DataRange1d(only_visible=True, range_padding=ROOM)
    plot.toolbar.stylesheets = [InlineStyleSheet(css=NOT_ON_PAPER)]
    across, up = (
        LinearAxis(axis_label=label, formatter=BasicTickFormatter(power_limit_low=WRITTEN_OUT))
        for label in (spec["xLabel"], spec["yLabel"])
    )
    plot.add_layout(across, "below")
    plot.add_layout(Grid(dimension=0, ticker=across.ticker))
    plot.add_layout(up, "left")
    plot.add_layout(Grid(dimension=1, ticker=up.ticker))
    up.ticker.desired_num_ticks = 6 if height_px > TALL_PX else 4
    drag = BoxZoomTool(dimensions="both" if plane else "width", match_aspect=plane)
    plot.add_tools(
        drag,
        PanTool(dimensions="both" if plane else "width"),
        WheelZoomTool(dimensions="both" if plane else "width", modifiers={"ctrl": True}),
        ZoomInTool(dimensions="both" if plane else "width"),
        ZoomOutTool(dimensions="both" if plane else "width"),
        ResetTool(),
    )
    if not plane:
        plot.add_tools(CrosshairTool(overlay=pointer, dimensions="height", visible=False))
    plot.toolbar.active_drag, plot.toolbar.logo = drag, None
    return plot


def curves(spec: dict[str, Any], height_px: int, shared: Shared) -> Plot:
    """A `LineChart`: its series over a common x axis or in a plane."""
    plot = frame(spec, height_px, shared)
    _spans(plot, spec)
    _zero(plot, spec)
    sources: list[tuple[FloatArray, ColumnDataSource, list[int]]] = []
    renderers: list[list[Any]] = []
    for number, series in enumerate(spec["series"]):
        source = _source(sources, number, series)
        renderers.append(_series(plot, source, number, series))
    _hover(plot, spec, sources, renderers)
    _marks(plot, spec)
    return plot


def numbers(packed: dict[str, Any]) -> FloatArray:
    """An axis' numbers in single precision where that does, as it halves the page."""
    values = unpack(packed)
    finite = values[np.isfinite(values)]
    if not len(finite) or np.abs(finite).max() * 2.0**-24 <= FINE * np.ptp(finite):
        return values.astype(np.float32)
    return values


def home(spec: dict[str, Any]) -> tuple[float, float]:
    """What the x axis shows at first: all of it.

    By the numbers as they are drawn: a first or last point that rounding puts outside would not
    count for the y axis, which holds the points between.
    """
    low, high = np.inf, -np.inf
    for series in spec["series"]:
        x = numbers(series["x"]).astype(np.float64)
        x = x[np.isfinite(x)]
        room = _bar_width(x) / 2 if series["style"] == "bars" else 0.0
        if len(x):
            low, high = min(low, float(x.min()) - room), max(high, float(x.max()) + room)
    if low > high:
        return 0.0, 1.0
    return (
        (low, high)
        if high > low
        else (low - (abs(low) * 1e-3 or 1.0), high + (abs(high) * 1e-3 or 1.0))
    )


def _bar_width(x: FloatArray) -> float:
    return float(x[1] - x[0]) if len(x) > 1 else 1.0


def _source(
    sources: list[tuple[FloatArray, ColumnDataSource, list[int]]],
    number: int,
    series: dict[str, Any],
) -> ColumnDataSource:
    """The data source of the series; series over the same x share one."""
    x = numbers(series["x"])
    same = [source for source in sources if np.array_equal(source[0], x) and series["sorted"]]
    if not same:
        same = [(x, ColumnDataSource({"x": x}), [])]
        sources += same
    _, source, members = same[0]
    members.append(number)
    for name in ("y", "low", "high"):
        if name in series:
            source.data[f"{name}{number}"] = numbers(series[name])
    return source


def _series(plot: Plot, source: ColumnDataSource, number: int, series: dict[str, Any]) -> list[Any]:
    """Draw one series; its colour is the page's business, so that light and dark differ."""
    x, y, style = "x", f"y{number}", series["style"]
    found: list[Any] = []
    if "low" in series and "high" in series:
        band = VArea(x=x, y1=f"low{number}", y2=f"high{number}", fill_alpha=0.18)
        found.append(plot.add_glyph(source, band))
    glyph: Any
    if style == "points":
        count = len(source.data["x"])
        size, opacity = next((size, alpha) for most, size, alpha in POINTS if count >= most)
        glyph = Scatter(x=x, y=y, marker="square", size=size, line_width=0, fill_alpha=opacity)
    elif style == "bars":
        width = 0.94 * _bar_width(np.asarray(source.data["x"], dtype=np.float64))
        glyph = VBar(x=x, top=y, bottom=0, width=width, line_width=0)
    else:
        glyph = Line(x=x, y=y, line_width=1.6, line_join="round")
        if series["dashed"]:
            glyph.line_dash = [6, 4]
    found.append(plot.add_glyph(source, glyph))
    for renderer in found:
        renderer.visible = not series["hidden"]
        renderer.tags = [series["colour"]]
        renderer.name = f"{number}"
    return found


def _hover(
    plot: Plot,
    spec: dict[str, Any],
    sources: Sequence[tuple[FloatArray, ColumnDataSource, list[int]]],
    renderers: Sequence[list[Any]],
) -> None:
    """What the pointer shows: all curves over the same x at once, or the nearest point."""
    for place, (x, source, members) in enumerate(sources):
        together = not spec.get("equal") and place == 0
        names = [spec["series"][number]["name"] for number in members]
        rows = [(_braced(spec["xLabel"]), f"@x{{{_decimals(x)}}}")]
        rows += [
            (_braced(name), f"@y{number}{{{_decimals(source.data[f'y{number}'])}}}")
            for name, number in zip(names, members, strict=True)
        ]
        plot.add_tools(
            HoverTool(
                renderers=[renderers[members[0]][-1]],
                mode="vline" if together else "mouse",
                tooltips=rows,
                attachment="horizontal",
                visible=False,
            )
        )


def _decimals(values: Any) -> str:
    """How Bokeh shows such numbers: to a ten-thousandth, the largest to three digits."""
    finite = np.abs(np.asarray(values, dtype=np.float64))
    largest = np.max(finite, initial=0.0, where=np.isfinite(finite))
    digits = 2 - math.floor(math.log10(largest)) if largest > 0.0 else 0
    return f"0.[{'0' * int(np.clip(digits, 4, 9))}]"


def _braced(text: str) -> str:
    """A name in which Bokeh finds nothing to fill in."""
    return text.replace("@", "＠").replace("$", "＄")


TINTED: dict[str, Any] = {"fill_alpha": 0.12, "line_color": None}
BESIDE: dict[str, Any] = {"y_units": "screen", "x_offset": 4, "text_font_size": "12px"}


def _spans(plot: Plot, spec: dict[str, Any]) -> None:
    for span in spec["spans"]:
        tint: dict[str, Any] = {"--bk-fill-color": f"var(--{span['colour']})"}
        plot.add_layout(
            BoxAnnotation(left=span["start"], right=span["end"], css_variables=tint, **TINTED)
        )
        if span["label"]:
            plot.add_layout(Label(x=span["start"], y=3, text=span["label"], **BESIDE))


def _zero(plot: Plot, spec: dict[str, Any]) -> None:
    """A line at zero where curves lie on both sides of it."""
    values = [unpack(series["y"]) for series in spec["series"]]
    if any(np.nanmin(shown, initial=0.0) < 0.0 < np.nanmax(shown, initial=0.0) for shown in values):
        line = Span(location=0.0, dimension="width", level="underlay", css_variables=_line("axis"))
        plot.add_layout(line)


def _marks(plot: Plot, spec: dict[str, Any]) -> None:
    """Upright lines; their labels alternate between two lines, one without room has none."""
    low, high = spec["home"]
    free = [low, low]
    a_letter = (high - low) / LETTERS_ACROSS
    for mark in sorted(spec["marks"], key=lambda drawn: float(drawn["x"])):
        x, colour = float(mark["x"]), mark["colour"]
        if not low <= x <= high:
            continue
        line = Span(location=x, dimension="height", line_dash="dashed", css_variables=_line(colour))
        plot.add_layout(line)
        end = x + a_letter * (len(mark["label"]) + 2)
        row = next((row for row in (0, 1) if free[row] <= x), None)
        if row is None or end > high:
            continue
        free[row] = end
        top_px = spec["height"] - 94 - 14 * row
        coloured: dict[str, Any] = {"--bk-text-color": f"var(--{colour})"}
        plot.add_layout(Label(x=x, y=top_px, text=mark["label"], css_variables=coloured, **BESIDE))


def _line(colour: str) -> dict[str, Any]:
    return {"--bk-line-color": f"var(--{colour})"}
