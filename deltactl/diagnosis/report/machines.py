"""The drawing of any kind of machine, with the parts marked that findings mean, and its legend.

A delta is seen from the front and a little from above, with the lengths of its robot file; single
axes and sensors are a row of blocks, the way the command passes.
"""

from __future__ import annotations

import html
from collections.abc import Sequence
from math import cos, sin

import numpy as np

from deltactl.charts.scenes import (
    BADGE_RADIUS,
    Label,
    Mark,
    Part,
    Point,
    Scene,
    badge,
    box,
    circle,
    hull,
    line,
    polygon,
    rod,
)
from deltactl.diagnosis.answer.records import Finding
from deltactl.diagnosis.report.names import called, unknown
from deltactl.diagnosis.report.templates import say
from deltactl.models.effects import card_of
from deltactl.models.linkage import Linkage, forward
from deltactl.models.robot import (
    AXES,
    ChainRobot,
    DeltaRobot,
    FloatArray,
    RangeSensor,
    RobotModel,
    ServoAxis,
    StepperAxis,
    per_arm,
)

EYE_AZIMUTH_RAD = -0.44
EYE_HEIGHT_RAD = 0.40
SIZE_PX = 330.0
MIDDLE_PX = 20.0
"""A label nearer to the middle is centred."""
POSES_RAD = (0.9, 0.6, 0.35, 0.1, -0.2, 1.2)
"""Arm angles to try, the same for all arms, until one can be assembled."""
NOMINAL_SENSOR_M = 0.6

RIGHT = np.array([-sin(EYE_AZIMUTH_RAD), cos(EYE_AZIMUTH_RAD), 0.0])
TOWARDS = np.array(
    [
        cos(EYE_AZIMUTH_RAD) * cos(EYE_HEIGHT_RAD),
        sin(EYE_AZIMUTH_RAD) * cos(EYE_HEIGHT_RAD),
        sin(EYE_HEIGHT_RAD),
    ]
)
UP = np.cross(TOWARDS, RIGHT)
AXIS_Y = 60.0


def machine_drawing(robot: RobotModel, findings: Sequence[Finding]) -> str:
    """The machine as SVG with the findings' components marked, and a legend, as HTML."""
    if isinstance(robot, DeltaRobot):
        scene, marks = DeltaDrawing(robot).build(), marks_of(findings, single=False)
    elif isinstance(robot, ChainRobot):
        scene, marks = chain_scene(robot), chain_marks(robot, findings)
    elif isinstance(robot, RangeSensor):
        scene, marks = sensor_scene(robot), widened(marks_of(findings, single=True))
    else:
        scene, marks = axis_scene(robot), marks_of(findings, single=True)
    return f'<figure class="drawing">{scene.svg(marks)}{_legend(findings, robot)}</figure>'


def _legend(findings: Sequence[Finding], robot: RobotModel) -> str:
    if not findings:
        return _note("nothing")
    rows = []
    for number, finding in enumerate(findings, 1):
        what = called(finding)
        if finding.effect == "unknown":
            part = "sensor" if isinstance(robot, RangeSensor) else finding.component
            what = unknown(part, finding.depends_on)
        rows.append(f'<li>{badge(number)}<a href="#finding-{number}">{html.escape(what)}</a></li>')
    note = _note("numbers") if isinstance(robot, DeltaRobot) else ""
    if any(finding.alternatives for finding in findings):
        note += _note("dashed")
    return f'<ol class="legend-list">{"".join(rows)}</ol>{note}'


def _note(key: str) -> str:
    return f'<p class="note">{say(f"drawing.{key}")}</p>'


def parts_of(effect: str, component: str) -> list[str]:
    """Names of the parts of a delta's drawing; empty for a component that is not on it."""
    stem, last = component[:-1], component[-1:]
    drawing = card_of(effect).drawing
    if stem in ("motor", "joint") and last in tuple("123"):
        return [f"{drawing.motor}{last}"]
    if stem == "arm" and last in tuple("123"):
        return [f"{drawing.rod}{last}"]
    if component.startswith("range_") and last in AXES:
        return [f"sensor_{last}"]
    if component == "sensors":
        return [f"sensor_{axis}" for axis in AXES]
    if drawing.everywhere:
        return list(drawing.everywhere)
    if component == "joints":
        return [f"{drawing.motor}{arm}" for arm in tuple("123")]
    if component == "arms":
        return [f"{rod}{arm}" for arm in tuple("123") for rod in ("upper_arm", "forearm")]
    return {"frame": ["base"], "platform": ["platform"]}.get(component, [])


def axis_parts_of(effect: str, component: str) -> list[str]:
    """The same for a single axis or sensor, where every component is `axis`."""
    return list(card_of(effect).drawing.axis)


def marks_of(findings: Sequence[Finding], single: bool) -> dict[str, list[Mark]]:
    """Part -> the findings that touch it, alternatives after the findings themselves."""
    find = axis_parts_of if single else parts_of
    marks: dict[str, list[Mark]] = {}
    for number, finding in enumerate(findings, 1):
        for name in find(finding.effect, finding.component):
            marks.setdefault(name, []).append(Mark(number))
    for number, finding in enumerate(findings, 1):
        for other in finding.alternatives:
            for name in find(other.effect, other.component):
                if all(mark.number != number for mark in marks.setdefault(name, [])):
                    marks[name].append(Mark(number, maybe=True))
    return marks


def axis_scene(robot: StepperAxis | ServoAxis) -> Scene:
    """Motor, gearbox, shaft, bearing, load, and the encoder below it."""
    linear = isinstance(robot, ServoAxis) and robot.motion == "linear"
    scene = Scene(say("drawing.axis", name=robot.name))
    scene.parts.append(_shaft(60.0, 290.0))
    scene.parts.append(_block("motor", 0.0, 34.0, 70.0, 52.0))
    scene.parts.append(_block("gear", 78.0, 28.0, 44.0, 64.0))
    scene.parts.append(_block("bearing", 166.0, 40.0, 22.0, 40.0))
    if linear:
        scene.parts.append(_block("load", 222.0, 28.0, 84.0, 44.0))
        rail = (line((206.0, 84.0), (330.0, 84.0)),)
        scene.parts.append(Part("rail", rail, ((206.0, 84.0), (330.0, 84.0)), (0, 0), -2.0, "line"))
    else:
        shape = (circle((264.0, AXIS_Y), 36.0), line((264.0, AXIS_Y), (292.0, 40.0)))
        corners = ((228.0, 24.0), (300.0, 96.0))
        scene.parts.append(Part("load", shape, corners, (264.0, 14.0), 1.0))
    scene.parts.append(_block("encoder", 240.0, 108.0, 48.0, 24.0, at=(302.0, 120.0)))
    gear = "screw" if linear else "gearbox"
    scene.labels += [
        Label("motor", (35.0, 106.0)),
        Label(gear, (100.0, 112.0)),
        Label("bearing", (177.0, 100.0)),
        Label("shaft", (142.0, 46.0)),
        Label("load" if isinstance(robot, ServoAxis) else "output", (264.0, 64.0)),
        Label("encoder", (264.0, 150.0)),
    ]
    return scene


def chain_scene(robot: ChainRobot) -> Scene:
    """The joints in a row, as blocks on one shaft, and the link that carries a load."""
    scene = Scene(say("drawing.axis", name=robot.name))
    apart = 330.0 / (len(robot.joints) + 1)
    scene.parts.append(_shaft(10.0, 330.0))
    for number, joint in enumerate(robot.joints):
        scene.parts.append(_block(joint, number * apart, 38.0, 0.6 * apart, 44.0))
        scene.labels.append(Label(str(number + 1), ((number + 0.3) * apart, 104.0)))
    scene.parts.append(_block("load", len(robot.joints) * apart, 30.0, 0.7 * apart, 60.0))
    return scene


def chain_marks(robot: ChainRobot, findings: Sequence[Finding]) -> dict[str, list[Mark]]:
    """Joint, or the load behind all joints -> the findings there."""
    marks: dict[str, list[Mark]] = {}
    for number, finding in enumerate(findings, 1):
        part = finding.component if finding.component in robot.joints else "load"
        marks.setdefault(part, []).append(Mark(number))
    return marks


def sensor_scene(robot: RangeSensor) -> Scene:
    """The sensor, its beam and what it looks at."""
    scene = Scene(say("drawing.sensor", name=robot.name))
    scene.parts.append(_block("sensor", 0.0, 36.0, 54.0, 48.0))
    ends = ((54.0, AXIS_Y), (290.0, AXIS_Y))
    scene.parts.append(Part("beam", (line(*ends),), ends, (172.0, AXIS_Y), -1.0, "beam"))
    scene.parts.append(_block("target", 290.0, 8.0, 14.0, 104.0))
    scene.labels += [
        Label("sensor", (27.0, 104.0)),
        Label("distance", (172.0, 50.0)),
        Label("target", (297.0, 130.0)),
    ]
    return scene


def widened(marks: dict[str, list[Mark]]) -> dict[str, list[Mark]]:
    """Marks of a single sensor: whatever is wrong, it is the sensor."""
    every = (mark for some in marks.values() for mark in some if not mark.maybe)
    return {"sensor": list({mark.number: mark for mark in every}.values())}


def _block(
    name: str, left: float, top: float, width: float, height: float, at: Point | None = None
) -> Part:
    """at: where its badge goes; None: above it."""
    corners = box(left, top, width, height)
    badge_at = at or (left + width / 2, top - 14.0)
    return Part(name, (polygon(corners),), tuple(corners), badge_at, 1.0)


def _shaft(left: float, right: float) -> Part:
    corners = box(left, AXIS_Y - 5.0, right - left, 10.0)
    return Part("shaft", (polygon(corners),), tuple(corners), (142.0, 24.0), -1.0)


class DeltaDrawing:
    """Builds the scene of one robot."""

    def __init__(self, robot: DeltaRobot):
        geometry = robot.geometry
        self.robot = robot
        self.base_m = per_arm(geometry.base_radius_m)
        self.platform_m = per_arm(geometry.platform_radius_m)
        self.upper_m = per_arm(geometry.upper_arm_m)
        self.out = np.stack(
            [np.cos(geometry.azimuth_rad), np.sin(geometry.azimuth_rad), np.zeros(3)], axis=1
        )
        self.along = np.stack([-self.out[:, 1], self.out[:, 0], np.zeros(3)], axis=1)
        self.angle_rad, self.centre_m = _pose(robot)
        reach = float(max(self.base_m.max() + self.upper_m.max(), -self.centre_m[2]))
        wide = 1.9 * float((self.base_m + self.upper_m * cos(self.angle_rad)).max())
        self.px_per_m = SIZE_PX / max(wide, -1.1 * float(self.centre_m[2]))
        self.unit_m = min(reach / 20.0, float(self.base_m.min()) / 6.0)
        self.scene = Scene(say("drawing.title", name=robot.name))

    def build(self) -> Scene:
        """All parts and labels."""
        self._plate("base", self.base_m, np.zeros(3))
        self._plate("platform", self.platform_m, self.centre_m)
        for arm in range(3):
            self._motor(arm)
            self._arm(arm)
        if self.robot.sensors is not None:
            for number, axis in enumerate(AXES):
                self._sensor(number, axis)
        x, y = self.at(self.centre_m)
        self.scene.labels.append(Label("platform", (x + 12.0, y + 40.0), "start"))
        return self.scene

    def at(self, where_m: FloatArray) -> Point:
        """A point of the robot frame on paper."""
        return (
            float(where_m @ RIGHT) * self.px_per_m,
            -float(where_m @ UP) * self.px_per_m,
        )

    def _add(
        self,
        name: str,
        outlines: list[list[Point]],
        middle_m: FloatArray,
        nearer: float,
        above: Point | None = None,
    ) -> None:
        """above: where the badge goes; None: in the middle."""
        corners = tuple(point for outline in outlines for point in outline)
        shapes = tuple(polygon(outline) for outline in outlines)
        depth = float(middle_m @ TOWARDS) + nearer
        place = self.at(middle_m) if above is None else above
        self.scene.parts.append(Part(name, shapes, corners, place, depth))

    def _plate(self, name: str, radius_m: FloatArray, middle_m: FloatArray) -> None:
        """A hexagon: a corner on each side of every arm."""
        half = 0.45 * radius_m[:, None] * self.along
        ends = middle_m + radius_m[:, None] * self.out
        order = np.argsort(np.arctan2(self.out[:, 1], self.out[:, 0]))
        outline = [
            self.at(corner)
            for arm in order
            for corner in (ends[arm] - half[arm], ends[arm] + half[arm])
        ]
        # The base is painted first: what hangs on it must not hide behind it.
        self._add(name, [outline], middle_m, nearer=0.02 if name == "platform" else -5.0)

    def _motor(self, arm: int) -> None:
        """On the motor axis beside the arm: first the gearbox, behind it the motor."""
        number, unit = arm + 1, self.unit_m
        joint = self.base_m[arm] * self.out[arm]
        ends = [joint + step * unit * self.along[arm] for step in (-0.7, 1.1, 3.6)]
        for name, start, end, radius in (("gear", 0, 1, 1.5), ("motor", 1, 2, 1.1)):
            middle = 0.5 * (ends[start] + ends[end])
            outlines = self._barrel(ends[start], ends[end], radius * unit, arm)
            x, y = self.at(middle)
            above = x, y - radius * unit * self.px_per_m - BADGE_RADIUS
            self._add(f"{name}{number}", outlines, middle, 0.05, above)
        x, y = self.at(ends[2] + 1.2 * unit * self.out[arm])
        side = "start" if x > MIDDLE_PX else "end" if x < -MIDDLE_PX else "middle"
        label = (x, y - 1.1 * unit * self.px_per_m - 2.3 * BADGE_RADIUS)
        self.scene.labels.append(Label(f"motor {number}", label, side))

    def _barrel(
        self, start_m: FloatArray, end_m: FloatArray, radius_m: float, arm: int
    ) -> list[list[Point]]:
        """A cylinder about the motor axis: its outline, and the face that looks at the eye."""
        turns = np.linspace(0.0, 2.0 * np.pi, 25)[:-1]
        rim = radius_m * (
            np.cos(turns)[:, None] * self.out[arm]
            + np.sin(turns)[:, None] * np.array([0.0, 0.0, 1.0])
        )
        faces = [[self.at(middle + edge) for edge in rim] for middle in (start_m, end_m)]
        nearer = int(end_m @ TOWARDS > start_m @ TOWARDS)
        return [hull(faces[0] + faces[1]), faces[nearer]]

    def _arm(self, arm: int) -> None:
        number = arm + 1
        shoulder = self.base_m[arm] * self.out[arm]
        down = np.array([0.0, 0.0, -sin(self.angle_rad)])
        elbow = shoulder + self.upper_m[arm] * (cos(self.angle_rad) * self.out[arm] + down)
        ball = self.centre_m + self.platform_m[arm] * self.out[arm]
        thick = 0.45 * self.unit_m * self.px_per_m
        upper = rod(self.at(shoulder), self.at(elbow), thick)
        self._add(f"upper_arm{number}", [upper], 0.5 * (shoulder + elbow), 0.08)
        offset = 0.9 * self.unit_m * self.along[arm]
        rods = [
            rod(self.at(elbow + side * offset), self.at(ball + side * offset), 0.35 * thick)
            for side in (-1.0, 1.0)
        ]
        bar = rod(self.at(elbow - offset), self.at(elbow + offset), 0.35 * thick)
        self._add(f"forearm{number}", [*rods, bar], 0.5 * (elbow + ball), 0.03)

    def _sensor(self, number: int, axis: str) -> None:
        """The sensor where its reading would be 0, and its beam to the platform."""
        assert self.robot.sensors is not None
        direction = self.robot.sensors.axes[number]
        offset_m = float(self.robot.sensors.offsets_m[number])
        reading_m = offset_m + float(direction @ self.centre_m)
        if not 0.2 * NOMINAL_SENSOR_M < reading_m < 4.0 * NOMINAL_SENSOR_M:
            reading_m = NOMINAL_SENSOR_M
        place = self.centre_m - reading_m * direction
        target = self.centre_m - float(self.platform_m.mean()) * direction
        eye, end = self.at(place), self.at(target)
        half = 0.75 * self.unit_m * self.px_per_m
        tail = self.at(place - 1.3 * self.unit_m * direction)
        shapes = (polygon(rod(tail, eye, half)), line(eye, end), circle(eye, 0.35 * half))
        above = (min(tail[0], eye[0]) - half - BADGE_RADIUS - 4.0, 0.5 * (tail[1] + eye[1]))
        self.scene.parts.append(Part(f"sensor_{axis}", shapes, (tail, eye), above, -8.0))
        low = max(tail[1], eye[1]) + half + 16.0
        self.scene.labels.append(Label(f"{axis} sensor", (tail[0], low)))


def _pose(robot: DeltaRobot) -> tuple[float, FloatArray]:
    """An arm angle at which the robot can be assembled, and where its platform is."""
    linkage = Linkage.of(robot.geometry)
    for angle_rad in POSES_RAD:
        position = forward(linkage, np.full((1, 3), angle_rad)).position_m[0]
        if np.isfinite(position).all() and position[2] < 0.0:
            return angle_rad, position
    # A robot that cannot be assembled is still drawn, with forearms that do not meet it.
    return POSES_RAD[0], np.array([0.0, 0.0, -float(per_arm(robot.geometry.forearm_m).mean())])
