"""Moving by hand: jog by buttons and keys, and going to a point. Held to the robot's limits."""

from __future__ import annotations

import asyncio
import math
from contextlib import suppress
from functools import partial
from typing import Any

import yaml
from nicegui import events, ui

from deltactl.firmware_py.controller.contract import Status
from deltactl.firmware_py.controller.states import State
from deltactl.foundation.errors import NotReady
from deltactl.models.linkage.vectors import Vector
from deltactl.web.behind.known_robots import KnownRobot
from deltactl.web.style import KEEP_KEYS, labelled, marked
from deltactl.web.visit import Visit, offer, why_not

STEPS_MM = {0.1: "0.1 mm", 1: "1 mm", 10: "10 mm", 50: "50 mm"}
STEPS_DEG = {0.1: "0.1°", 1: "1°", 5: "5°", 20: "20°"}
MOST_WAITING = 3
"""Presses that may be ahead of the robot; more would run on after the hand is off."""
BY_HAND_JOBS = ("jog", "go-to")
KEYS: dict[str, tuple[int, int]] = {
    "ArrowRight": (0, 1),
    "ArrowUp": (1, 1),
    "PageUp": (2, 1),
    "ArrowLeft": (0, -1),
    "ArrowDown": (1, -1),
    "PageDown": (2, -1),
}
"""Key to axis and direction."""
KEYS_SAY = (
    "Keys, once the cross is clicked: arrows for x and y, page up and down for z. A tap moves one "
    "step; a key that is held moves on, and stops when it is released."
)
CROSS = (
    (None, (1, 1, "Y+"), None, (2, 1, "Z+")),
    ((0, -1, "X−"), None, (0, 1, "X+"), None),
    (None, (1, -1, "Y−"), None, (2, -1, "Z−")),
)
"""As seen from above, with z beside it: axis, direction and text of each button."""


class MotionCard:
    """Buttons, keys and fields, for operators."""

    def __init__(self, visit: Visit):
        self._visit = visit
        self._goal: Vector | None = None
        self._in_order = asyncio.Lock()
        self._sending = 0
        self._held = False
        """Whether a key is held: the moves of it end when it is released."""
        self._releases = 0
        self._by_key: list[int] = []
        """Jobs that the key which is held has sent."""
        self._told_serial = 0
        """From this status on, the newest move that was sent is in what the daemon tells."""
        self._parts: list[Any] = []
        self._suggested = False
        self._why: str | None = None
        with (
            ui.card().classes("w-full p-3 gap-2 jog"),
            ui.row().classes("items-start gap-6"),
        ):
            self._unable = ui.label().classes("w-full text-sm").props("data-testid=unable")
            self._platform()
            self._arms()
            self._point()

    def enable(self, state: str, job: str | None) -> None:
        """Offer what fits the robot's state, which is empty without a daemon.

        Moves by hand may follow one another; a job comes to its end, or is cancelled, before.
        """
        moves = state == State.RUNNING.value and job in (None, *BY_HAND_JOBS)
        fitting = (State.READY, State.PLANNING)
        why = "" if moves else why_not("Moving by hand", fitting, state)
        if why == self._why:
            return
        self._why = why
        for part in self._parts:
            offer(part, why)
        self._unable.set_text(why)
        self._unable.set_visibility(bool(why))

    def suggest(self, known: KnownRobot) -> None:
        """Put home, where any robot can be, into the fields once the robot is known."""
        if self._suggested:
            return
        self._suggested = True
        for field, value_m in zip(self._fields, known.home_m or (), strict=False):
            field.set_value(round(1e3 * value_m, 2) + 0.0)

    def _platform(self) -> None:
        with ui.column().classes("gap-1"):
            ui.label("Move the platform").classes("font-bold")
            self._step_mm = ui.toggle(STEPS_MM, value=1).props("dense no-caps data-testid=step-mm")
            cross = ui.element("div").classes("jog-cross").props("tabindex=0 data-testid=cross")
            labelled(cross, KEYS_SAY)
            with cross:
                for place in (place for row in CROSS for place in row):
                    if place is None:
                        ui.element("span")
                        continue
                    axis, sign, text = place
                    call = partial(self.jog, axis, sign)
                    self._button(text, f"jog-{'xyz'[axis]}{sign:+d}", call)
            ui.label(KEYS_SAY).classes("with-keys text-xs text-gray-600 max-w-xs").props(
                "data-testid=jog-keys"
            )
            cross.on("keydown", js_handler=KEEP_KEYS)
            cross.on("keydown", self._key_down, args=["key", "repeat"])
            cross.on("keyup", self._key_up, args=["key"])
            cross.on("focusout", self._release)

    def _arms(self) -> None:
        with ui.column().classes("gap-1"):
            ui.label("Move one arm").classes("font-bold")
            self._step_deg = ui.toggle(STEPS_DEG, value=1).props("dense no-caps")
            for arm in range(3):
                with ui.row().classes("gap-2 items-center"):
                    for sign, word in ((-1, "up"), (1, "down")):
                        call = partial(self.turn, arm, sign)
                        self._button(f"{arm + 1} {word}", f"arm{arm + 1}{word}", call)

    def _point(self) -> None:
        with ui.column().classes("gap-1"):
            ui.label("Go to a point (mm)").classes("font-bold")
            self._fields = []
            with ui.row().classes("gap-2"):
                for name in "xyz":
                    field = ui.number(name, step=1, format="%.2f").classes("w-20")
                    self._fields.append(marked(field, f"goto-{name}"))
            self._button("Go there", "goto", self.go)

    def _button(self, text: str, mark: str, call: Any) -> None:
        button = ui.button(text, on_click=call).props("no-caps outline")
        self._parts.append(marked(button, mark))

    async def _key_down(self, event: events.GenericEventArguments) -> None:
        """A step; what a key that is held repeats is left out while enough steps wait."""
        key, repeats = event.args.get("key"), bool(event.args.get("repeat"))
        if key not in KEYS or self._why:
            return
        self._held = self._held or repeats
        if not repeats or not self._full():
            await self.jog(*KEYS[key], by_key=True)

    async def _key_up(self, event: events.GenericEventArguments) -> None:
        if event.args.get("key") in KEYS:
            await self._release()

    async def _release(self) -> None:
        """A key that was held is released, or the cross has lost the keys: nothing moves on."""
        numbers, self._by_key = self._by_key, []
        if not self._held:
            return
        self._held = False
        self._releases += 1  # what is on its way to the daemon is called off when it is answered
        await self._call_off(numbers)

    async def _call_off(self, numbers: list[int]) -> None:
        status = self._visit.site.link.seen.status
        if not numbers or status is None:
            return

        def call() -> None:
            with self._visit.site.link.client() as client:
                for number in numbers:
                    with suppress(NotReady):  # it has ended meanwhile
                        client.cancel(number)

        await self._visit.act("stop the jog", call)
        self._goal = None

    async def jog(self, axis: int, sign: int, by_key: bool = False) -> None:
        """Move the platform one step along an axis; by_key: until the key is released."""
        if self._full():
            ui.notify(f"{MOST_WAITING} steps wait already: this press was left out", type="warning")
            return
        here = self._here()
        known = self._known()
        if here is None or known is None:
            return
        wanted = list(here)
        wanted[axis] += sign * float(self._step_mm.value or 0) * 1e-3
        goal = known.held(here, (wanted[0], wanted[1], wanted[2]))
        if math.dist(goal, here) < 1e-6:
            limit = known.limit_at((wanted[0], wanted[1], wanted[2]))
            ui.notify(f"no further this way: {limit}", type="warning")
            return
        releases = self._releases
        number = await self._to(goal, known)
        if not by_key or not isinstance(number, int):
            return
        if releases != self._releases:
            await self._call_off([number])
        else:
            self._by_key = [*self._by_key, number][-MOST_WAITING - 2 :]

    async def turn(self, arm: int, sign: int) -> None:
        """Turn one arm by a step."""
        status, known = self._visit.site.link.seen.status, self._known()
        if status is None or known is None or status.angles_rad is None:
            return
        if status.state != "ready" or self._under_way(status):
            ui.notify("wait until the arm is there", type="warning")
            return
        angles = [math.degrees(angle) for angle in status.angles_rad]
        angles[arm] = known.held_angle(angles[arm] + sign * float(self._step_deg.value or 0))
        self._goal = None
        await self._send(to_angles(known.file, (angles[0], angles[1], angles[2])), "jog")

    async def go(self) -> None:
        """Go to the point in the fields."""
        known = self._known()
        values = [field.value for field in self._fields]
        if known is None:
            return
        if any(value is None for value in values):
            ui.notify("give x, y and z in mm", type="warning")
            return
        x_m, y_m, z_m = (float(value) * 1e-3 for value in values)
        if limit := known.limit_at((x_m, y_m, z_m)):
            ui.notify(f"cannot go there: {limit}", type="warning")
            return
        await self._to((x_m, y_m, z_m), known)

    def _known(self) -> KnownRobot | None:
        known = self._visit.site.known(self._visit.site.link.seen)
        if known is None:
            ui.notify("no robot file of this name here; start deltactl web with --robot FILE")
        return known

    def _here(self) -> Vector | None:
        """Where the next step starts: where the last one ends, while that is under way."""
        status = self._visit.site.link.seen.status
        if status is None or status.position_m is None:
            return None
        if status.state == "running" and status.job not in BY_HAND_JOBS:
            ui.notify("a job runs; wait, or cancel it", type="warning")
            return None
        if not self._under_way(status):
            return status.position_m
        if self._goal is None:
            ui.notify("wait until the arm is there", type="warning")
        return self._goal

    def _under_way(self, status: Status) -> bool:
        """Whether a move is being made or waits, or was sent and no status tells of it yet."""
        unheard = self._sending > 0 or self._visit.site.link.seen.serial < self._told_serial
        engaged = status.state in (State.PLANNING.value, State.RUNNING.value)
        return unheard or engaged or bool(status.queued)

    def _full(self) -> bool:
        status = self._visit.site.link.seen.status
        return status is not None and len(status.queued) + self._sending >= MOST_WAITING

    async def _to(self, goal: Vector, known: KnownRobot) -> Any:
        before, self._goal = self._goal, goal
        number = await self._send(to_point(known.file, goal, "jog"), "move")
        if not number:
            self._goal = before
        return number

    async def _send(self, text: str, name: str) -> Any:
        def call() -> int:
            return self._visit.site.link.submit_text(text, f"{name}.yaml")

        self._sending += 1
        try:
            async with self._in_order:
                return await self._visit.act(name, call)
        finally:
            self._sending -= 1
            # One status may have been on its way while the daemon took the move.
            self._told_serial = self._visit.site.link.seen.serial + 2


def to_point(robot_file: str, position_m: Vector, name: str = "go-to") -> str:
    """A job that brings the platform straight to a point [m] in the robot's frame."""
    point = [round(value, 7) for value in position_m]
    return _job(name, robot_file, {"shape": "straight", "to_m": point})


def to_angles(robot_file: str, angles_deg: Vector, name: str = "jog") -> str:
    """A job that brings the arms to angles [degrees]."""
    angles = [round(value, 6) for value in angles_deg]
    return _job(name, robot_file, {"shape": "joints", "angles_deg": [angles]})


def _job(name: str, robot_file: str, path: dict[str, Any]) -> str:
    job = {
        "name": name,
        "robot": robot_file,
        "path": path,
        "timing": {"mode": "accelerated", "speed_mps": 0.1},
        "inverse_kinematics": {"kind": "geometry"},
    }
    return yaml.safe_dump(job, sort_keys=False)
