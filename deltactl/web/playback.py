"""A recorded run again: the robot in 3D and its curves, both at the time of one slider."""

from __future__ import annotations

import bisect
import json
import time
from pathlib import Path
from typing import Any

from nicegui import ui

from deltactl.foundation.errors import DeltactlError
from deltactl.web.behind.history import Curves
from deltactl.web.behind.known_robots import KnownRobot
from deltactl.web.behind.shelf import Listed
from deltactl.web.plots import chart, cursor_at
from deltactl.web.scene import RobotScene
from deltactl.web.style import painted
from deltactl.web.visit import Visit

PLAYED, ROBOT = "played.json", "played.yaml"
"""What the worker writes: curves and counts, and the robot file of the recording."""
FRAME_S = 0.1
SPEEDS = {0.25: "¼×", 1: "1×", 4: "4×"}
SAYS = "Error: distance between the measured position and the target at that time."


class Playback:
    """Closed until it is asked for; open, it costs the browser a second drawing."""

    def __init__(self, visit: Visit, listed: Listed):
        self._visit, self._listed = visit, listed
        self._box = ui.column().classes("w-full gap-1").props("data-testid=playback")
        self._box.set_visibility(False)
        self._timer: Any = None

    async def open(self) -> None:
        """Show it, or close it. Raises what the worker says."""
        if self._box.visible:
            self.close()
            return
        made = self._listed.made
        made.mkdir(parents=True, exist_ok=True)
        if not (made / PLAYED).is_file():
            await self._visit.site.tasks.run("playback", self._listed.path, made)
        self._box.set_visibility(True)
        with self._box:
            self._build(made)

    def close(self) -> None:
        """Take the drawing away."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        self._box.clear()
        self._box.set_visibility(False)

    def _build(self, made: Path) -> None:
        played = json.loads((made / PLAYED).read_text(encoding="utf-8"))
        self._counts, self._measured_m = played["counts"], played["measured_m"]
        self._curves = Curves(played["t_s"], played["values"])
        self._end_s = self._curves.t_s[-1]
        with ui.row().classes("w-full items-center gap-2 no-wrap"):
            self._button = ui.button(icon="play_arrow", on_click=self._turn)
            self._button.props('round dense data-testid=play aria-label="Play or pause"')
            self._slider = ui.slider(min=0.0, max=self._end_s, step=0.02, value=0.0)
            self._slider.classes("grow").props('data-testid=time aria-label="Time"')
            self._at = ui.label().classes("figures text-sm whitespace-nowrap")
            self._at.props("data-testid=played-at")
            self._speed = ui.toggle(SPEEDS, value=1).props("dense no-caps").classes("gt-xs")
        with ui.row().classes("w-full gap-2 items-stretch"):
            with ui.column().classes("grow basis-80 min-w-0 gap-0"):
                self._scene = self._drawn(made)
            with ui.column().classes("grow basis-96 min-w-0 gap-0"):
                self._chart = chart(self._curves, scrolls=True, cursor=True)
                ui.label(SAYS).classes("text-xs text-gray-600")
        self._playing = False
        self._shown_s = -1.0
        self._timer = ui.timer(FRAME_S, self._step)

    def _drawn(self, made: Path) -> RobotScene | None:
        """The robot of the recording; none where it cannot be drawn."""
        try:
            known = KnownRobot.of(made / ROBOT)
        except DeltactlError:
            ui.label("The robot of this recording cannot be drawn.").classes("text-sm")
            return None
        with ui.element("div").classes("scene-box w-full"):
            return RobotScene(known)

    def _turn(self) -> None:
        self._playing = not self._playing
        self._button.set_icon("pause" if self._playing else "play_arrow")
        self._began = (time.monotonic(), float(self._slider.value or 0.0))
        if self._playing and self._began[1] >= self._end_s:
            self._began = (self._began[0], 0.0)

    async def _step(self) -> None:
        """Show the time of the slider, and the next once the browser has painted that one."""
        if self._playing:
            began_s, from_s = self._began
            t_s = from_s + float(self._speed.value or 1) * (time.monotonic() - began_s)
            self._slider.set_value(round(min(t_s, self._end_s), 2))
            if t_s >= self._end_s:
                self._turn()
        t_s = float(self._slider.value or 0.0)
        if t_s != self._shown_s:
            self._shown_s = t_s
            self._show(t_s)
            await painted()

    def _show(self, t_s: float) -> None:
        """Robot, cursor and figure at one time."""
        place = max(0, bisect.bisect_right(self._curves.t_s, t_s) - 1)
        counts, measured_m = self._counts[place], self._measured_m[place]
        if self._scene is not None:
            self._scene.update(tuple(counts), None if measured_m is None else tuple(measured_m))
        self._chart.run_chart_method("setOption", cursor_at(t_s, self._curves))
        self._at.set_text(f"{t_s:.1f} of {self._end_s:.1f} s")
