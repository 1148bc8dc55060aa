"""Curves below one another with one axis of time: live ones, and those of a recording."""

from __future__ import annotations

from typing import Any, Final

from nicegui import ui

from deltactl.web.behind.history import Curves
from deltactl.web.style import painted
from deltactl.web.visit import Visit

GROUPS: Final[tuple[tuple[str, tuple[str, ...]], ...]] = (
    ("Position x, y, z [mm]", ("x", "y", "z")),
    ("Error [mm]", ("error",)),
    ("Ranges x, y, z [mm]", ("range x", "range y", "range z")),
    ("Step rate of motors 1, 2, 3 [1/s]", ("motor 1", "motor 2", "motor 3")),
)
COLOURS: Final = ("#dc2626", "#16a34a", "#3b82f6")
"""x, y, z; motors 1, 2, 3. They are seen on white and on black."""
GREY: Final = "#8593a8"
CURSOR: Final = "#d97706"
TOP_PX, HEIGHT_PX, GAP_PX = 22, 74, 38
Entry = dict[str, Any]
HIDDEN: Final[Entry] = {"show": False}
STILL: Final[Entry] = {"animation": False}
TITLES: Final[Entry] = {"fontSize": 12, "fontWeight": "normal", "color": GREY}
GRID_LINES: Final[Entry] = {"lineStyle": {"color": GREY, "opacity": 0.3}}
LIVE_S: Final = 30.0
LIVE_PERIOD_S: Final = 1.0
LIVE_SAYS = (
    "Error: distance between where the sensors see the platform and where the step counts put it. "
    "Against the target: playback of the recording."
)


def options(curves: Curves, scrolls: bool, cursor: bool = False) -> dict[str, Any]:
    """What ECharts draws. scrolls: with a bar to choose a stretch of time."""
    grids, x_axes, y_axes, titles, series = [], [], [], [], []
    for number, (title, names) in enumerate(GROUPS):
        top = TOP_PX + number * (HEIGHT_PX + GAP_PX)
        grids.append({"left": 52, "right": 12, "top": top, "height": HEIGHT_PX})
        first, last = (round(curves.t_s[0]), curves.t_s[-1]) if curves.t_s else (0.0, 1.0)
        label = {"color": GREY, "formatter": "{value} s", "showMaxLabel": False}
        scale = {"min": first, "max": last, "axisLine": {"onZero": False}, "splitLine": HIDDEN}
        x_axes.append(_axis(number, axisLabel=label, **scale))
        lines = {"axisLine": HIDDEN, "axisTick": HIDDEN, "splitLine": GRID_LINES}
        y_axes.append(_axis(number, scale=True, splitNumber=2, axisLabel={"color": GREY}, **lines))
        titles.append({"text": title, "left": 8, "top": top - TOP_PX + 2, "textStyle": TITLES})
        for place, name in enumerate(names):
            series.append(_line(curves, name, number, COLOURS[place]))
        if cursor:
            series.append(_line(Curves(), f"cursor {number}", number, CURSOR))
    every = list(range(len(GROUPS)))
    bars = {"xAxisIndex": every, "filterMode": "none"}
    zoom = [{"type": "slider", "bottom": 4, "height": 18, **bars}, {"type": "inside", **bars}]
    tooltip = {"trigger": "axis", "renderMode": "richText"} if scrolls else HIDDEN
    axes = {"grid": grids, "xAxis": x_axes, "yAxis": y_axes, "title": titles}
    curves_of = {"series": series, "dataZoom": zoom if scrolls else [], "tooltip": tooltip}
    return STILL | axes | curves_of


def _line(curves: Curves, name: str, grid: int, colour: str) -> dict[str, Any]:
    values = curves.values.get(name, [])
    data = [list(pair) for pair in zip(curves.t_s, values, strict=False)]
    return {"id": name, "name": name, "color": colour} | _drawn(grid, colour, data)


def _drawn(grid: int, colour: str, data: list[list[float | None]]) -> Entry:
    style = {"showSymbol": False, "lineStyle": {"width": 1.5, "color": colour}}
    return {"type": "line", "xAxisIndex": grid, "yAxisIndex": grid, "data": data} | style


def _axis(grid: int, **more: Any) -> Entry:
    return {"type": "value", "gridIndex": grid} | more


def cursor_at(t_s: float, curves: Curves) -> dict[str, Any]:
    """What moves the cursors of a chart to a time."""
    lines = []
    for number, (_, names) in enumerate(GROUPS):
        rows = (curves.values.get(name, []) for name in names)
        seen = [value for row in rows for value in row if value is not None] or [0.0]
        ends = [[t_s, min(seen)], [t_s, max(seen)]]
        lines.append({"id": f"cursor {number}", "data": ends})
    return {"series": lines}


def chart(curves: Curves, scrolls: bool, cursor: bool = False) -> ui.echart:
    """A chart of all groups."""
    drawn = ui.echart(options(curves, scrolls, cursor), renderer="svg")
    return drawn.classes("w-full plots")


def preview_options(paths_m: list[list[list[float]]]) -> dict[str, Any]:
    """A picture of paths from above (x, y) and from the side (x, z), both on one scale."""
    points = [point for path in paths_m for point in path]
    middle = [(max(row) + min(row)) / 2 for row in zip(*points, strict=True)]
    half = max(max(row) - min(row) for row in zip(*points, strict=True)) / 2 * 1e3 + 5.0
    grids, titles = [], []
    x_axes: list[Entry] = []
    y_axes: list[Entry] = []
    series: list[Entry] = []
    for number, (title, up) in enumerate((("from above: x, y [mm]", 1), ("side: x, z [mm]", 2))):
        left = f"{4 + 50 * number}%"
        titles.append({"text": title, "left": left, "textStyle": TITLES})
        grids.append({"left": left, "width": "42%", "top": 34, "bottom": 20, "containLabel": True})
        for axes, axis in ((x_axes, 0), (y_axes, up)):
            centre = 1e3 * middle[axis]
            ends = {"min": round(centre - half), "max": round(centre + half), "splitNumber": 2}
            label = {"color": GREY, "showMinLabel": False, "showMaxLabel": False}
            lines = {"splitLine": HIDDEN, "axisLine": {"onZero": False}}
            axes.append(_axis(number, axisLabel=label, **ends, **lines))
        for path in paths_m:
            data: list[list[float | None]] = [[1e3 * point[0], 1e3 * point[up]] for point in path]
            series.append(_drawn(number, COLOURS[2], data))
    axes_of = {"title": titles, "grid": grids, "xAxis": x_axes, "yAxis": y_axes}
    return STILL | axes_of | {"series": series, "tooltip": HIDDEN}


class LivePlots:
    """Half a minute that scrolls; paused, the last two minutes with a bar to look through them."""

    def __init__(self, visit: Visit):
        self._visit = visit
        self._paused = False
        with (
            ui.card().classes("w-full p-1 plots-card"),
            ui.expansion("Live plots: position, error, ranges, step rate", icon="show_chart")
            .classes("w-full")
            .props("data-testid=plots dense") as self._box,
        ):
            with ui.row().classes("w-full items-center gap-2 no-wrap"):
                self._pause = ui.button("Pause", icon="pause", on_click=self._turn)
                self._pause.props("no-caps dense outline data-testid=plots-pause").classes("px-2")
                ui.label(LIVE_SAYS).classes("text-xs text-gray-600")
            self._place = ui.element("div").classes("w-full")
        self._chart: ui.echart | None = None
        self._box.on_value_change(self.update)
        ui.timer(LIVE_PERIOD_S, self.update)

    async def update(self) -> None:
        """Draw what has come; nothing while nobody can see it."""
        if self._box.value and not self._paused and self._visit.tab == "Robot":
            self._draw()
            await painted()

    def _turn(self) -> None:
        self._paused = not self._paused
        self._pause.set_text("Go on" if self._paused else "Pause")
        self._pause.set_icon("play_arrow" if self._paused else "pause")
        self._draw()

    def _draw(self) -> None:
        curves = self._visit.site.trace.curves()
        shown = curves if self._paused else curves.last(LIVE_S)
        if self._chart is None:
            with self._place:
                self._chart = chart(shown, self._paused)
            return
        self._chart.options.clear()
        self._chart.options.update(options(shown, self._paused))
        self._chart.update()
