"""A running job as viewers draw it: frames, scene, poses, ranges and log, ten times a second.

In: counts, targets, readings and events of a run. Out: messages on the channels of
`deltactl.recording.format.channels`. The scene is written once; frames move its parts.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import Any, Protocol

import numpy as np

from deltactl.drivers.ranging.contract import Gate, Reading
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.models.linkage import Linkage
from deltactl.models.linkage.scalar import counted_pose, forward_one
from deltactl.models.linkage.skeleton import Skeleton, quaternion, turn_x_to
from deltactl.models.robot import AXES
from deltactl.recording.format.channels import (
    LOG,
    POSES,
    RANGES,
    SCENE,
    TRANSFORMS,
    UNUSED,
    ViewedChannel,
)

PERIOD_NS = 100_000_000
FRESH_NS = 200_000_000
"""Three ranges of this age at most make a position."""
BASE = "base"
ARM_M, ROD_M, PLATE_M = 0.024, 0.010, 0.012
BLUE, GREY, DARK = (0.23, 0.51, 0.96, 1.0), (0.58, 0.64, 0.72, 1.0), (0.12, 0.16, 0.23, 0.3)
ERRORS = frozenset({"fault", "stop", "stopped", "estop", "alarm"})
LEVEL_INFO, LEVEL_ERROR = 2, 4
STRAIGHT = (0.0, 0.0, 0.0, 1.0)

Message = dict[str, Any]
ONE_BEAM: Message = {"start_angle": 0.0, "end_angle": 0.0}
STAYS: Message = {"lifetime": {"sec": 0, "nsec": 0}, "frame_locked": True}
EVEN: Message = {"bottom_scale": 1.0, "top_scale": 1.0}
Point = Sequence[float]


class ViewRecorder(Protocol):
    """What `deltactl.recording.writer.RunRecorder` has for this."""

    def wall_ns(self, t_ns: int) -> int: ...
    def viewed(self, t_ns: int, channel: ViewedChannel, message: Message) -> None: ...


class View:
    """Writes what a viewer needs beside a recording."""

    def __init__(self, robot: RobotFile, recorder: ViewRecorder):
        self._robot = robot
        self._recorder = recorder
        self._forward = partial(forward_one, Linkage.of(robot.geometry))
        self._skeleton = Skeleton.of(robot.geometry)
        self._next_ns: dict[str, int] = {}
        self._ranges: dict[str, tuple[int, float]] = {}

    def begin(self, t_ns: int, counts: Sequence[int]) -> None:
        """The scene, where the sensors are, and where the robot is."""
        entities = [self._entity(t_ns, BASE, [self._plate(self._skeleton.base_radius_m, DARK)])]
        entities.append(
            self._entity(t_ns, "platform", [self._plate(self._skeleton.platform_radius_m, BLUE)])
        )
        for number in range(3):
            arm, rod = self._skeleton.upper_arm_m[number], self._skeleton.forearm_m[number]
            aside = self._skeleton.rod_offset_m
            entities.append(self._entity(t_ns, f"arm_{number + 1}", [_rod(arm, ARM_M, BLUE, 0.0)]))
            rods = [_rod(rod, ROD_M, GREY, x) for x in (-aside, aside)]
            entities.append(self._entity(t_ns, f"forearm_{number + 1}", rods))
        self._recorder.viewed(t_ns, SCENE, {"deletions": [], "entities": entities})
        self._transforms(t_ns, [(f"sensor_{axis}", *place) for axis, place in self._beams()])
        self.counts(t_ns, counts)

    def counts(self, t_ns: int, counts: Sequence[int]) -> None:
        """Where the counts put the robot."""
        if not self._due("counts", t_ns):
            return
        rad_per_step = self._robot.drive.rad_per_step
        angles, position = counted_pose(counts, rad_per_step, self._forward)
        links = self._skeleton.links(angles, position)
        names = [f"{part}_{number}" for part in ("arm", "forearm") for number in (1, 2, 3)]
        frames = [
            (name, link.middle_m, quaternion(link.rotation))
            for name, link in zip(names, links, strict=False)
        ]
        if position is not None:
            frames.append(("platform", position, STRAIGHT))
            self._pose(t_ns, "commanded", position)
        self._transforms(t_ns, frames)

    def target(self, t_ns: int, position_m: Point) -> None:
        """Where the platform was asked to be."""
        if self._due("target", t_ns) and all(map(math.isfinite, position_m)):
            self._pose(t_ns, "target", position_m)

    def reading(self, reading: Reading) -> None:
        """A good reading as a scan of one beam; three of them as a position."""
        if reading.gate is not Gate.GOOD or not math.isfinite(reading.distance_m):
            return
        self._ranges[reading.axis] = (reading.t_ns, reading.distance_m)
        if self._due(f"range {reading.axis}", reading.t_ns):
            place = {"frame_id": f"sensor_{reading.axis}", "pose": _pose((0.0, 0.0, 0.0))}
            scan = place | ONE_BEAM | {"ranges": [reading.distance_m], "intensities": []}
            self._stamped(reading.t_ns, RANGES[reading.axis], scan)
        self._measured(reading.t_ns)

    def event(self, t_ns: int, kind: str, text: str) -> None:
        """Something that happened."""
        level = LEVEL_ERROR if kind in ERRORS else LEVEL_INFO
        message = {"level": level, "message": text or kind, "name": kind, "file": "", "line": 0}
        self._stamped(t_ns, LOG, message)

    def _measured(self, t_ns: int) -> None:
        sensors = self._robot.sensors
        seen = [self._ranges.get(axis) for axis in AXES]
        fresh = [one[1] for one in seen if one is not None and t_ns - one[0] < FRESH_NS]
        if sensors is None or len(fresh) < len(AXES) or not self._due("measured", t_ns):
            return
        try:
            place = np.linalg.solve(sensors.axes, np.array(fresh) - sensors.offsets_m)
        except np.linalg.LinAlgError:
            return
        self._pose(t_ns, "measured", place.tolist())

    def _due(self, what: str, t_ns: int) -> bool:
        if t_ns < self._next_ns.get(what, t_ns):
            return False
        self._next_ns[what] = t_ns + PERIOD_NS
        return True

    def _beams(self) -> list[tuple[str, tuple[Point, Point]]]:
        """Places of the sensors, and the turn that brings their x axis into their beam."""
        described = self._robot.sensors
        if described is None:
            return []
        found: list[tuple[str, tuple[Point, Point]]] = []
        for name in AXES:
            axis = np.array(getattr(described, name).axis)
            place = (-getattr(described, name).offset_m * axis).tolist()
            found.append((name, (place, turn_x_to(axis))))
        return found

    def _pose(self, t_ns: int, name: str, position_m: Point) -> None:
        self._stamped(t_ns, POSES[name], {"frame_id": BASE, "pose": _pose(position_m)})

    def _transforms(self, t_ns: int, frames: Sequence[tuple[str, Point, Point]]) -> None:
        stamp = _stamp(self._recorder.wall_ns(t_ns))
        head = {"timestamp": stamp, "parent_frame_id": BASE}
        parts = [
            {"child_frame_id": name, "translation": _vector(place), "rotation": _turn(turn)}
            for name, place, turn in frames
        ]
        self._recorder.viewed(t_ns, TRANSFORMS, {"transforms": [head | part for part in parts]})

    def _entity(self, t_ns: int, frame: str, cylinders: list[Message]) -> Message:
        stamp = _stamp(self._recorder.wall_ns(t_ns))
        named = {"timestamp": stamp, "frame_id": frame, "id": frame}
        return named | STAYS | {"cylinders": cylinders} | {part: [] for part in UNUSED}

    def _plate(self, radius_m: float, colour: Point) -> Message:
        size = (2.0 * radius_m, 2.0 * radius_m, PLATE_M)
        return _cylinder((0.0, 0.0, 0.0), STRAIGHT, size, colour)

    def _stamped(self, t_ns: int, channel: ViewedChannel, message: Message) -> None:
        stamp = _stamp(self._recorder.wall_ns(t_ns))
        self._recorder.viewed(t_ns, channel, {"timestamp": stamp} | message)


def _rod(length_m: float, width_m: float, colour: Point, aside_m: float) -> Message:
    """A cylinder along y: Foxglove's are along z."""
    half = math.sqrt(0.5)
    return _cylinder(
        (aside_m, 0.0, 0.0), (half, 0.0, 0.0, half), (width_m, width_m, length_m), colour
    )


def _cylinder(place: Point, turn: Point, size: Point, colour: Point) -> Message:
    red, green, blue, alpha = colour
    painted = {"color": {"r": red, "g": green, "b": blue, "a": alpha}}
    return {"pose": _pose(place, turn), "size": _vector(size)} | EVEN | painted


def _pose(position_m: Point, turn: Point = STRAIGHT) -> Message:
    return {"position": _vector(position_m), "orientation": _turn(turn)}


def _vector(point: Point) -> Message:
    x, y, z = (round(float(value), 7) for value in point)
    return {"x": x, "y": y, "z": z}


def _turn(turn: Point) -> Message:
    x, y, z, w = (round(float(value), 7) for value in turn)
    return {"x": x, "y": y, "z": z, "w": w}


def _stamp(wall_ns: int) -> Message:
    return {"sec": wall_ns // 1_000_000_000, "nsec": wall_ns % 1_000_000_000}
