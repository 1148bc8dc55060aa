"""The robot in 3D: as the counts say, and beside it a ball where the sensors say it is."""

from __future__ import annotations

import math
import time
from collections import deque
from itertools import pairwise
from typing import Any

from nicegui import ui

from deltactl.models.linkage.skeleton import Matrix, Skeleton, placed
from deltactl.models.linkage.vectors import Vector
from deltactl.web.behind.known_robots import KnownRobot
from deltactl.web.style import QUIET

ARM, ROD, PLATE, SENSED, CULPRIT = "#3b82f6", "#94a3b8", "#1e293b", "#f59e0b", "#dc2626"
LINK_RADIUS_M, ROD_RADIUS_M, JOINT_RADIUS_M = 0.012, 0.005, 0.022
NUMBER = "font-weight: bold; color: #1e293b; background: #f1f5f9; padding: 0 2px"
TRACED = "#059669"
AXES = (("x", (1, 0, 0), "#dc2626"), ("y", (0, 1, 0), "#16a34a"), ("z", (0, 0, 1), "#3b82f6"))
AREA, FLOOR, FLOOR_LINES = "#a855f7", "#cbd5e1", 4
TRACE_STEP_M, TRACE_LINES = 0.003, 300
JUMP_M = 0.05
"""Counters that are set (homing) draw no line."""
BALL_S = 0.5
"""At rest the ball moves by the noise of the sensors alone, and need not be followed closely."""
DIGITS = 5
"""A hundredth of a millimetre is finer than any screen."""


class RobotScene:
    """A scene that is moved by one message a frame."""

    def __init__(self, known: KnownRobot):
        self._known = known
        self._skeleton = Skeleton.of(known.robot.geometry)
        self._links: list[Any] = []
        self._marks: dict[str, Any] = {}
        self._traced: deque[Any] = deque()
        self._drawn: Vector | None = None
        self._last: tuple[object, object] = (None, None)
        self._drawn_s = -math.inf
        reach = self._skeleton.base_radius_m + sum(self._skeleton.upper_arm_m) / 3
        self.view = ui.scene(
            grid=False,
            camera=ui.scene.perspective_camera(fov=42, near=0.01, far=50),
            background_color="#f1f5f9",
        ).classes("w-full h-full")
        self.view.move_camera(
            x=1.6 * reach, y=-1.6 * reach, z=1.3 * reach, look_at_z=-0.7 * reach, duration=0
        )
        self.view.on("init", js_handler=QUIET)
        with self.view:
            self._build()

    def update(self, counts: tuple[int, ...], measured_m: Vector | None) -> None:
        """Draw it where the counts and the sensors say it is."""
        seen, now_s = (counts, measured_m), time.monotonic()
        only_noise = counts == self._last[0] and now_s - self._drawn_s < BALL_S
        if seen == self._last or only_noise:
            return
        self._last, self._drawn_s = seen, now_s
        angles, position = self._known.pose(counts)
        calls: list[list[Any]] = []
        for part, its in zip(self._links, self._skeleton.links(angles, position), strict=False):
            calls += [_moved(part, its.middle_m), _turned(part, its.rotation)]
        if position is not None:
            calls.append(_moved(self._platform, position))
            calls += self._trace(position)
        calls.append(_shown(self._sensed, measured_m is not None))
        if measured_m is not None:
            calls.append(_moved(self._sensed, measured_m))
        self.view.run_method("run_methods", calls)

    def _trace(self, position: Vector) -> list[list[Any]]:
        """Where the platform has been of late: lines a few millimetres long, bounded in number."""
        before, self._drawn = self._drawn or position, position
        step_m = math.dist(before, position)
        if 0.0 < step_m < TRACE_STEP_M:
            self._drawn = before
        if not TRACE_STEP_M <= step_m < JUMP_M:
            return []
        upright = abs(before[2] - position[2]) > step_m / 2
        where = placed(before, position, (1.0, 0.0, 0.0) if upright else (0.0, 0.0, 1.0))
        line = self._next_line()
        return [_moved(line, where.middle_m), _turned(line, where.rotation), _long(line, step_m)]

    def _next_line(self) -> Any:
        """A new one, or the oldest: the browser keeps something of every line that it deletes."""
        if len(self._traced) < TRACE_LINES:
            with self.view:
                line = self.view.line([0.0, -0.5, 0.0], [0.0, 0.5, 0.0]).material(TRACED)
            self._traced.append(line)
        else:
            self._traced.rotate(-1)
        return self._traced[-1]

    def blame(self, components: list[str]) -> None:
        """Colour the parts that a diagnosis names; an empty list clears them."""
        for name, part in self._marks.items():
            blamed = any(_covers(component, name) for component in components)
            part.material(CULPRIT if blamed else part.plain)

    def _build(self) -> None:
        frame = self._skeleton
        self._surroundings()
        plate = self.view.cylinder(frame.base_radius_m, frame.base_radius_m, 0.012, 48)
        plate.rotate(1.5708, 0.0, 0.0).move(0, 0, 0.03).material(PLATE, opacity=0.25)
        for number, (x_m, y_m, z_m) in enumerate(frame.shoulders_m().tolist(), start=1):
            joint = self.view.sphere(JOINT_RADIUS_M).move(x_m, y_m, z_m)
            self._mark(f"motor{number}", joint, PLATE)
            self.view.text(str(number), NUMBER).move(1.2 * x_m, 1.2 * y_m, z_m + 0.05)
        for number, length_m in enumerate(frame.upper_arm_m, start=1):
            with self.view.group() as link:
                bar = self.view.cylinder(LINK_RADIUS_M, LINK_RADIUS_M, length_m, 12)
                self._mark(f"arm{number}", bar, ARM)
            self._links.append(link)
        for length_m in frame.forearm_m:
            with self.view.group() as link:
                for side in (-1, 1):
                    rod = self.view.cylinder(ROD_RADIUS_M, ROD_RADIUS_M, length_m, 8)
                    rod.move(side * frame.rod_offset_m, 0, 0).material(ROD)
            self._links.append(link)
        with self.view.group().with_name("platform") as self._platform:
            radius = frame.platform_radius_m
            disc = self.view.cylinder(radius, radius, 0.012, 32).rotate(1.5708, 0.0, 0.0)
            self._mark("platform", disc, ARM)
        self._sensed = self.view.sphere(0.02).material(SENSED, opacity=0.85)
        for axis, (x_m, y_m, z_m) in _sensor_places(self._known).items():
            box = self.view.box(0.03, 0.03, 0.03).move(x_m, y_m, z_m)
            self._mark(f"range_{axis}", box, SENSED)

    def _surroundings(self) -> None:
        """Axes from the origin, the work area halfway down, and the floor below all."""
        long_m = 0.45 * self._skeleton.base_radius_m
        for name, end_m, colour in AXES:
            tip_m = [long_m * part for part in end_m]
            self.view.line([0.0, 0.0, 0.0], tip_m).material(colour)
            self.view.text(name, NUMBER).move(*(1.15 * part for part in tip_m))
        area = self._known.work_area
        if area is None:
            return
        for start, end in pairwise([*area.edge_m, area.edge_m[0]]):
            self.view.line(list(start), list(end)).material(AREA)
        size_m = 1.3 * max(max(abs(x_m), abs(y_m)) for x_m, y_m, _ in area.edge_m)
        for share in range(-FLOOR_LINES, FLOOR_LINES + 1):
            at_m = size_m * share / FLOOR_LINES
            for ends in (([at_m, -size_m], [at_m, size_m]), ([-size_m, at_m], [size_m, at_m])):
                one, other = ([*point, area.floor_m] for point in ends)
                self.view.line(one, other).material(FLOOR)

    def _mark(self, name: str, part: Any, colour: str) -> None:
        part.material(colour)
        part.plain = colour
        self._marks[name] = part


def _covers(component: str, part: str) -> bool:
    """Whether blaming a component means this part of the drawing."""
    groups = {"joints": "motor", "arms": "arm", "sensors": "range_", "frame": "motor"}
    return component == part or part.startswith(groups.get(component, "\0"))


def _sensor_places(known: KnownRobot) -> dict[str, Vector]:
    """A sensor looks along its axis from `offset` away."""
    sensors = known.robot.sensors
    if sensors is None:
        return {}
    places: dict[str, Vector] = {}
    for name in ("x", "y", "z"):
        axis = getattr(sensors, name)
        x_m, y_m, z_m = (-axis.offset_m * part for part in axis.axis)
        places[name] = (x_m, y_m, z_m)
    return places


# Each also notes the new place in the object, from which a browser that reconnects gets all.


def _moved(part: Any, point: Vector) -> list[Any]:
    part.x, part.y, part.z = (round(value, DIGITS) for value in point)
    return ["move", part.id, part.x, part.y, part.z]


def _turned(part: Any, rotation: Matrix) -> list[Any]:
    part.R = rotation
    return ["rotate", part.id, rotation]


def _long(part: Any, length_m: float) -> list[Any]:
    part.sx, part.sy, part.sz = 1.0, round(length_m, DIGITS), 1.0
    return ["scale", part.id, part.sx, part.sy, part.sz]


def _shown(part: Any, visible: bool) -> list[Any]:
    part.visible_ = visible
    return ["visible", part.id, visible]
