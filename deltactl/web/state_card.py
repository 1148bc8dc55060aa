"""The tab of the robot: drawing, figures, ranges, job, and the buttons that fit its state."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path
from typing import Any

from nicegui import ui

from deltactl.firmware_py.controller.contract import JobResult, SensorStatus, Status
from deltactl.firmware_py.controller.states import ALLOWED, Request
from deltactl.web.behind.known_robots import KnownRobot
from deltactl.web.behind.link import Seen
from deltactl.web.heal_card import HealCard
from deltactl.web.motion_card import BY_HAND_JOBS, MotionCard
from deltactl.web.plots import LivePlots
from deltactl.web.scene import RobotScene
from deltactl.web.style import marked, small
from deltactl.web.trial_cards import HiddenFaultCard, TrialCard
from deltactl.web.visit import Visit, offer, what_next, why_not

OUTCOMES = {
    "done": "has ended",
    "cancelled": "was cancelled",
    "stopped": "was stopped",
    "fault": "was ended by a fault",
    "refused": "was refused",
}


def said_of_end(result: JobResult) -> str:
    """How a job ended, in one sentence."""
    why = f" ({result.why})" if result.why and result.outcome != "done" else ""
    kept = f": its recording is {Path(result.recording).stem}" if result.recording else ""
    return f"{result.name} {OUTCOMES.get(result.outcome, result.outcome)}{why}{kept}."


ARROWS = {"up": "arrow_upward", "down": "arrow_downward"}


class EndedCard:
    """Seen from the end of a job to the beginning of the next."""

    def __init__(self, visit: Visit):
        self._shown: JobResult | None = None
        with ui.row().classes("w-full items-center gap-2") as self._row:
            self._says = ui.label().classes("text-sm").props("data-testid=ended")
            self._show = show = ui.button("Report and diagnosis", icon="troubleshoot")
            show.on_click(lambda: visit.show_tab("Recordings"))
            show.props("no-caps dense outline data-testid=show-recording").classes("px-2")
        self._row.set_visibility(False)

    def update(self, status: Status, ended: JobResult | None) -> None:
        """Follow the job; moves by hand are in no list of recordings."""
        if status.job is not None or ended is None or ended.name in BY_HAND_JOBS:
            ended = None
        if ended is self._shown:
            return
        self._shown = ended
        self._row.set_visibility(ended is not None)
        if ended is not None:
            self._says.set_text(said_of_end(ended))
            self._show.set_visibility(bool(ended.recording))


AMBER = "Amber: the distance sensors (boxes), and where they see the platform (ball)."
TURN = "Drag to turn, wheel or two fingers to zoom."
AREA = "Purple: the edge of the work area halfway down."
DRAWN = f"Blue: where the step counts put it, green its way. {AMBER} {AREA} {TURN}"
RED = "Red: {names}, named by the diagnosis of {found_in}."
NO_WEBGL = (
    "No drawing: this browser offers no WebGL (switch on hardware acceleration, or use another "
    "browser). Everything else on this page works without it."
)
NOT_HOMED = f"Not homed: the arms are drawn as if the counts were right. {AMBER} {TURN}"

BUTTONS: tuple[tuple[str, str, Request, str], ...] = (
    ("On", "power_on", Request.ON, "power"),
    ("Off", "power_off", Request.OFF, "power_off"),
    ("Home", "home", Request.HOME, "home"),
    ("Pause", "pause", Request.PAUSE, "pause"),
    ("Resume", "resume", Request.RESUME, "play_arrow"),
    ("Cancel job", "cancel", Request.CANCEL, "close"),
)


class StateCard:
    """Everything that changes while the robot moves."""

    def __init__(self, visit: Visit):
        self._visit = visit
        self.scene: RobotScene | None = None
        self.motion: MotionCard | None = None
        self._texts: dict[str, Any] = {}
        self._buttons: dict[Request, Any] = {}
        self._state: str | None = None
        with ui.row().classes("w-full items-stretch gap-2"):
            with ui.card().classes("p-1 grow basis-96 min-w-0 overflow-hidden"):
                self._box = ui.element("div").classes("scene-box w-full")
                ui.label(NO_WEBGL).classes("no-webgl text-sm px-1").props("data-testid=no-webgl")
                with ui.row().classes("w-full items-center gap-2 px-1") as self._blamed:
                    self._texts["blamed"] = ui.label().classes("text-sm text-red-800 grow")
                    self._texts["blamed"].props("data-testid=blamed")
                    clear = ui.button("Clear", on_click=lambda: self.blame([], ""))
                    clear.props("no-caps dense outline data-testid=blame-clear").classes("px-2")
                self._blamed.set_visibility(False)
                self._texts["caption"] = ui.label().classes(
                    "scene-caption text-xs text-gray-600 px-1"
                )
            with ui.column().classes("grow basis-80 gap-2"):
                self._state_and_buttons()
                self._trial = TrialCard(visit)
                self._heal = HealCard(visit) if visit.operates else None
                self._figures()
                hidden = visit.site.hidden_fault
                self._fault_card = (
                    HiddenFaultCard(visit, hidden)
                    if hidden is not None and visit.operates
                    else None
                )
        self._plots = LivePlots(visit)
        if visit.operates:
            self.motion = MotionCard(visit)

    def blame(self, components: list[str], found_in: str) -> None:
        """Red in the drawing: what a diagnosis names; nothing of it where there is none."""
        if self.scene is not None:
            self.scene.blame(components)
        self._texts["blamed"].set_text(RED.format(names=", ".join(components), found_in=found_in))
        self._blamed.set_visibility(bool(components))

    def update(self, seen: Seen) -> None:
        """Show a status, or why there is none."""
        status = seen.status
        known = self._visit.site.known(seen)
        if self._fault_card is not None:
            self._fault_card.update(known, "" if status is None else status.state)
        self._trial.update(status)
        if self._heal is not None:
            self._heal.update(status)
        if status is None:
            self._set("next", seen.problem)
            self._set_state("")
            if self.motion is not None:
                self.motion.enable("", None)
            return
        self._draw(status, known)
        if self.motion is not None and known is not None:
            self.motion.suggest(known)
        self._set_state(status.state)
        if self.motion is not None:
            self.motion.enable(status.state, status.job)
        self._set("next", what_next(status, self._visit.operates))
        self._set("caption", DRAWN if status.position_m else NOT_HOMED)
        self._numbers(status, seen)
        self._job(status, seen.ended)

    def _state_and_buttons(self) -> None:
        with ui.card().classes("w-full p-3 gap-2"):
            self._texts["next"] = ui.label("...").classes("text-base").props("data-testid=next")
            if self._visit.operates:
                with ui.row().classes("gap-2"):
                    for text, method, request, icon in BUTTONS:
                        button = ui.button(
                            text, icon=icon, on_click=lambda _, name=method: self._visit.ask(name)
                        )
                        marked(button.props("no-caps dense").classes("px-3"), method)
                        self._buttons[request] = button
            with ui.row().classes("w-full items-center gap-3 no-wrap") as self._job_row:
                self._bar = (
                    ui.linear_progress(0.0, show_value=False)
                    .classes("grow")
                    .props("size=14px rounded instant-feedback")
                )
                self._texts["left"] = (
                    ui.label().classes("figures whitespace-nowrap").props("data-testid=left")
                )
            self._texts["job"] = ui.label().classes("text-sm").props("data-testid=job")
            self._ended = EndedCard(self._visit)
            self._queue = ui.column().classes("w-full gap-0").props("data-testid=queue")
            self._waiting: tuple[tuple[int, str], ...] = ()

    def _figures(self) -> None:
        with ui.card().classes("w-full p-3 gap-1 figures"):
            for key, name in (
                ("position", "Platform x, y, z"),
                ("measured", "by the sensors"),
                ("angles", "Arm angles"),
                ("counts", "Step counts"),
                ("range_x", "Range x"),
                ("range_y", "Range y"),
                ("range_z", "Range z"),
                ("recording", "Recording"),
                ("robot_file", "Robot file"),
            ):
                with ui.row().classes("w-full no-wrap gap-2"):
                    ui.label(name).classes("text-gray-600 w-32 shrink-0")
                    self._texts[key] = marked(ui.label("-").classes("ellipsis"), key)

    def _draw(self, status: Status, known: KnownRobot | None) -> None:
        if self.scene is None and known is not None:
            with self._box:
                self.scene = RobotScene(known)
        if self.scene is not None and known is not None:
            self.scene.update(status.counts, known.measured(status.sensors))

    def _numbers(self, status: Status, seen: Seen) -> None:
        known = self._visit.site.known(seen)
        measured = known.measured(status.sensors) if known else None
        self._set(
            "position", in_millimetres(status.position_m) if status.position_m else "not homed"
        )
        self._set("measured", in_millimetres(measured) if measured else "-")
        angles = status.angles_rad
        self._set("angles", in_degrees(angles) if angles else "not homed")
        self._set("counts", "  ".join(str(count) for count in status.counts))
        self._set("recording", status.recording_error or (status.recording or "-").split("/")[-1])
        self._set("robot_file", status.robot_file or "-")
        for sensor, noise_m in zip(status.sensors, seen.noise_m, strict=False):
            self._set(f"range_{sensor.axis}", _range(sensor, noise_m))

    def _job(self, status: Status, ended: JobResult | None) -> None:
        self._ended.update(status, ended)
        self._job_row.set_visibility(status.job is not None)
        planned = f"Planning {', '.join(status.planning)}." if status.planning else "No job."
        self._set("job", status.job or planned)
        self._show_queue(tuple(zip(status.queued_ids, status.queued, strict=False)))
        if status.job is not None:
            progress = round(status.progress, 3)
            if self._bar.value != progress:
                self._bar.set_value(progress)
            left = "" if status.seconds_left is None else f", {status.seconds_left:.0f} s left"
            self._set("left", f"{status.progress:.0%}{left}")

    def _show_queue(self, waiting: tuple[tuple[int, str], ...]) -> None:
        """Jobs that wait, in the order in which they will run; each can be left out."""
        if waiting == self._waiting:
            return
        self._waiting = waiting
        self._queue.clear()
        with self._queue:
            for place, (number, name) in enumerate(waiting, 1):
                with ui.row().classes("w-full items-center gap-0 no-wrap"):
                    ui.label(f"{place}. then {name}").classes("grow ellipsis text-sm").props(
                        "data-testid=waiting"
                    )
                    if self._visit.operates:
                        for word, to in (("up", place - 1), ("down", place + 1)):
                            self._mover(word, number, name, to, len(waiting))
                        leave_out = partial(self._leave_out, number, name)
                        small(f"leave out {name}", "close", leave_out, f"leave-out-{place}")

    def _mover(self, word: str, number: int, name: str, to: int, most: int) -> None:
        """An arrow; room for one where there is no place to go to."""
        if 1 <= to <= most:
            move = partial(self._move, number, name, to)
            small(f"move {name} {word}", ARROWS[word], move, f"move-{word}-{to}")
        else:
            ui.element("div").classes("w-7 shrink-0")

    async def _move(self, number: int, name: str, place: int) -> None:
        def call() -> None:
            with self._visit.site.link.client() as client:
                client.move(number, place)

        await self._visit.act(f"move {name}", call)

    async def _leave_out(self, number: int, name: str) -> None:
        def call() -> None:
            with self._visit.site.link.client() as client:
                client.cancel(number)

        await self._visit.act(f"leave out {name}", call)

    def _set_state(self, state: str) -> None:
        """Offer the buttons that the daemon would take now."""
        if state == self._state:
            return
        self._state = state
        for text, _, request, _ in BUTTONS:
            if request in self._buttons:
                offer(self._buttons[request], why_not(text, ALLOWED[request], state))

    def _set(self, key: str, text: str) -> None:
        label = self._texts[key]
        if label.text != text:
            label.set_text(text)


def in_millimetres(point: tuple[float, ...]) -> str:
    """A point [m] as the page shows it."""
    return "  ".join(_fixed(value * 1e3, 2) for value in point) + " mm"


def in_degrees(angles: tuple[float, ...]) -> str:
    """Angles [rad] as the page shows them."""
    return "  ".join(_fixed(math.degrees(angle), 3) for angle in angles) + "°"


def _fixed(value: float, digits: int) -> str:
    """Without a minus where only zeros are left."""
    return f"{round(value, digits) + 0.0:.{digits}f}"


def _range(sensor: SensorStatus, noise_m: float | None) -> str:
    if sensor.distance_m is None:
        return f"- ({sensor.gate}, {sensor.health})"
    noise = "" if noise_m is None else f" ± {noise_m * 1e3:.1f}"
    state = (
        ""
        if (sensor.gate, sensor.health) == ("good", "ok")
        else f" ({sensor.gate}, {sensor.health})"
    )
    return f"{sensor.distance_m * 1e3:.1f}{noise} mm{state}"
