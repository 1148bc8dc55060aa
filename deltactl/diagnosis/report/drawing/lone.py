"""Single axes and lone sensors as a row of blocks, the way the command passes."""

from __future__ import annotations

from deltactl.diagnosis.report.drawing.scene import (
    Label,
    Mark,
    Part,
    Scene,
    box,
    circle,
    line,
    polygon,
)
from deltactl.models.robot import RangeSensor, ServoAxis, StepperAxis

AXIS_Y = 60.0


def axis_scene(robot: StepperAxis | ServoAxis) -> Scene:
    """Motor, gearbox, shaft, bearing, load, and the encoder below it."""
    linear = isinstance(robot, ServoAxis) and robot.motion == "linear"
    scene = Scene(f"The axis {robot.name}")
    scene.parts.append(_bar("shaft", 60.0, 290.0, 5.0, depth=-1.0))
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
    scene.parts.append(_block("encoder", 240.0, 108.0, 48.0, 24.0))
    scene.parts[-1] = _badge_beside(scene.parts[-1], 302.0, 120.0)
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


def sensor_scene(robot: RangeSensor) -> Scene:
    """The sensor, its beam and what it looks at."""
    scene = Scene(f"The sensor {robot.name}")
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
    """Marks of a lone sensor: whatever is wrong, it is the sensor."""
    every = [mark for some in marks.values() for mark in some]
    sure = {mark.number: mark for mark in every if not mark.maybe}
    return {"sensor": list(sure.values())}


def _block(name: str, left: float, top: float, width: float, height: float) -> Part:
    corners = box(left, top, width, height)
    return Part(name, (polygon(corners),), tuple(corners), (left + width / 2, top - 14.0), 1.0)


def _badge_beside(part: Part, x: float, y: float) -> Part:
    return Part(part.name, part.shapes, part.corners, (x, y), part.depth, part.style)


def _bar(name: str, left: float, right: float, half: float, depth: float) -> Part:
    corners = box(left, AXIS_Y - half, right - left, 2.0 * half)
    return Part(name, (polygon(corners),), tuple(corners), (142.0, 24.0), depth)
