"""The topics, and the robot as messages on them. Times are nanoseconds since 1970."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import foxglove
import numpy as np
from foxglove import Context
from foxglove.channels import (
    FrameTransformsChannel,
    LaserScanChannel,
    LogChannel,
    PoseInFrameChannel,
    SceneUpdateChannel,
)
from foxglove.messages import (
    Color,
    CylinderPrimitive,
    FrameTransform,
    FrameTransforms,
    LaserScan,
    Log,
    LogLevel,
    Pose,
    PoseInFrame,
    Quaternion,
    SceneEntity,
    SceneUpdate,
    SpherePrimitive,
    Timestamp,
    Vector3,
)

from deltactl.firmware_py.controller.contract import Status
from deltactl.firmware_py.run_report.tracking import robot_of
from deltactl.foundation.errors import ServiceError
from deltactl.foundation.plain_file import said_of_output
from deltactl.models.linkage import Linkage, skeleton
from deltactl.models.linkage.skeleton import Placed, Skeleton
from deltactl.models.linkage.vectors import Vector
from deltactl.models.robot import AXES, FloatArray
from deltactl.recording.reading.reader import read_run
from deltactl.recording.reading.run import Run
from deltactl.web.behind.known_robots import KnownRobot, KnownRobots
from deltactl.web.behind.link import DaemonLink

BASE: Final = "base"
ARM_M, ROD_M, PLATE_M = 0.024, 0.010, 0.012
BLUE, GREY, AMBER, DARK = (
    Color(r=0.23, g=0.51, b=0.96, a=1.0),
    Color(r=0.58, g=0.64, b=0.72, a=1.0),
    Color(r=0.96, g=0.62, b=0.04, a=0.9),
    Color(r=0.12, g=0.16, b=0.23, a=0.3),
)
ERRORS: Final = frozenset({"fault", "stop", "stopped", "estop", "alarm"})
"""Kinds of events that are shown as errors."""
ALONG_Y: Final = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
"""Foxglove's cylinders extend along z, the drawing's links along their second column."""


class RobotChannels:
    """Writes the robot on its topics of one context."""

    def __init__(self, known: KnownRobot, context: Context):
        self._known = known
        self._skeleton = Skeleton.of(known.robot.geometry)
        self._tf = FrameTransformsChannel("/tf", context=context)
        self._scene = SceneUpdateChannel("/robot", context=context)
        self._sensed = SceneUpdateChannel("/measured_ball", context=context)
        self._poses = {
            name: PoseInFrameChannel(f"/pose/{name}", context=context)
            for name in ("target", "commanded", "measured")
        }
        self._ranges = {axis: LaserScanChannel(f"/range/{axis}", context=context) for axis in AXES}
        self._log = LogChannel("/log", context=context)

    def counts(self, t_ns: int, counts: Sequence[int]) -> None:
        """Where the counts put the robot."""
        angles, position = self._known.pose(tuple(int(count) for count in counts))
        transforms = [
            self._transform(t_ns, f"sensor_{axis}", *place)
            for axis, place in self._sensors().items()
        ]
        if position is not None:
            transforms.append(self._transform(t_ns, "platform", position, Quaternion(w=1.0)))
            self.pose(t_ns, "commanded", position)
        self._tf.log(FrameTransforms(transforms=transforms), log_time=t_ns)
        links = self._skeleton.links(angles, position)
        parts = [self._link(link, number) for number, link in enumerate(links)]
        cylinders = [cylinder for some in parts for cylinder in some] + self._plates(position)
        entity = SceneEntity(timestamp=stamp(t_ns), frame_id=BASE, id="robot", cylinders=cylinders)
        self._scene.log(SceneUpdate(entities=[entity]), log_time=t_ns)

    def measured(self, t_ns: int, position_m: Vector) -> None:
        """Where the sensors see the platform."""
        self.pose(t_ns, "measured", position_m)
        ball = SpherePrimitive(
            pose=_pose(position_m), size=Vector3(x=0.03, y=0.03, z=0.03), color=AMBER
        )
        entity = SceneEntity(timestamp=stamp(t_ns), frame_id=BASE, id="measured", spheres=[ball])
        self._sensed.log(SceneUpdate(entities=[entity]), log_time=t_ns)

    def pose(self, t_ns: int, name: str, position_m: Vector) -> None:
        """'target', 'commanded' or 'measured'."""
        message = PoseInFrame(timestamp=stamp(t_ns), frame_id=BASE, pose=_pose(position_m))
        self._poses[name].log(message, log_time=t_ns)

    def range(self, t_ns: int, axis: str, distance_m: float) -> None:
        """One reading: a scan of a single beam along the sensor's axis."""
        scan = LaserScan(
            timestamp=stamp(t_ns),
            frame_id=f"sensor_{axis}",
            pose=_pose((0, 0, 0)),
            start_angle=0.0,
            end_angle=0.0,
            ranges=[distance_m],
            intensities=[],
        )
        self._ranges[axis].log(scan, log_time=t_ns)

    def event(self, t_ns: int, kind: str, text: str) -> None:
        """Something that happened."""
        level = LogLevel.Error if kind in ERRORS else LogLevel.Info
        self._log.log(
            Log(timestamp=stamp(t_ns), level=level, message=text or kind, name=kind),
            log_time=t_ns,
        )

    def _sensors(self) -> dict[str, tuple[Vector, Quaternion]]:
        """Places of the sensors, and the turn that brings their x axis into their beam."""
        described = self._known.robot.sensors
        if described is None:
            return {}
        found = {}
        for name in AXES:
            sensor = getattr(described, name)
            axis = np.array(sensor.axis)
            x_m, y_m, z_m = (-sensor.offset_m * axis).tolist()
            found[name] = ((x_m, y_m, z_m), _quaternion(skeleton.turn_x_to(axis)))
        return found

    def _transform(
        self, t_ns: int, child: str, place: Vector, rotation: Quaternion
    ) -> FrameTransform:
        return FrameTransform(
            timestamp=stamp(t_ns),
            parent_frame_id=BASE,
            child_frame_id=child,
            translation=_vector(place),
            rotation=rotation,
        )

    def _link(self, link: Placed, number: int) -> list[CylinderPrimitive]:
        """An upper arm, or the two rods of a forearm."""
        rotation = np.array(link.rotation)
        arm = number < len(self._skeleton.upper_arm_m)
        lengths = (*self._skeleton.upper_arm_m, *self._skeleton.forearm_m)
        width, colour = (ARM_M, BLUE) if arm else (ROD_M, GREY)
        turned = quaternion(rotation @ ALONG_Y)
        sideways = [0.0] if arm else [-self._skeleton.rod_offset_m, self._skeleton.rod_offset_m]
        made = []
        for aside_m in sideways:
            x_m, y_m, z_m = (np.array(link.middle_m) + aside_m * rotation[:, 0]).tolist()
            size = Vector3(x=width, y=width, z=lengths[number])
            pose = Pose(position=_vector((x_m, y_m, z_m)), orientation=turned)
            made.append(_cylinder(pose, size, colour))
        return made

    def _plates(self, position_m: Vector | None) -> list[CylinderPrimitive]:
        plates = [((0.0, 0.0, 0.03), self._skeleton.base_radius_m, DARK)]
        if position_m is not None:
            plates.append((position_m, self._skeleton.platform_radius_m, BLUE))
        return [
            _cylinder(_pose(place), Vector3(x=2 * radius, y=2 * radius, z=PLATE_M), colour)
            for place, radius, colour in plates
        ]


def stamp(t_ns: int) -> Timestamp:
    """A time of Foxglove."""
    return Timestamp(sec=t_ns // 1_000_000_000, nsec=t_ns % 1_000_000_000)


def quaternion(rotation: FloatArray) -> Quaternion:
    """Quaternion of a rotation matrix."""
    return _quaternion(skeleton.quaternion(rotation.tolist()))


def _cylinder(pose: Pose, size: Vector3, colour: Color) -> CylinderPrimitive:
    return CylinderPrimitive(pose=pose, size=size, bottom_scale=1.0, top_scale=1.0, color=colour)


def _quaternion(parts: tuple[float, float, float, float]) -> Quaternion:
    x, y, z, w = parts
    return Quaternion(x=x, y=y, z=z, w=w)


def _vector(point: Vector) -> Vector3:
    return Vector3(x=float(point[0]), y=float(point[1]), z=float(point[2]))


def _pose(point: Vector) -> Pose:
    return Pose(position=_vector(point), orientation=Quaternion(x=0.0, y=0.0, z=0.0, w=1.0))


SCENE_HZ = 25.0
NS = 1e9


def convert(recording: Path, out: Path) -> int:
    """Write `out` (.mcap) for Foxglove; returns how many scenes it holds.

    Raises RecordingError when the recording cannot be read, or `out` exists.
    """
    run = read_run(recording)
    robot = robot_of(run)
    known = KnownRobot(f"{robot.name}.yaml", robot, Linkage.of(robot.geometry))
    context = foxglove.Context()
    channels = RobotChannels(known, context)
    with said_of_output(out, fresh=True), foxglove.open_mcap(out, context=context):
        return _write(run, known, channels)


def _write(run: Run, known: KnownRobot, channels: RobotChannels) -> int:
    start_ns = run.configuration.start_epoch_ns
    times_ns = np.arange(0, run.end_ns + 1, int(NS / SCENE_HZ), dtype=np.int64)
    every = run.edges.counts_at(times_ns)
    for t_ns, counts in zip(times_ns.tolist(), every.tolist(), strict=True):
        channels.counts(start_ns + t_ns, counts)
    for t_ns, point in zip(run.targets.t_ns.tolist(), run.targets.position_m.tolist(), strict=True):
        if np.isfinite(point).all():
            channels.pose(start_ns + t_ns, "target", (point[0], point[1], point[2]))
    for axis, readings in run.readings.items():
        good = readings.where(readings.good)
        for t_ns, far_m in zip(good.t_ns.tolist(), good.distance_m.tolist(), strict=True):
            channels.range(start_ns + t_ns, axis, far_m)
    _measured(run, known, channels, start_ns)
    for event in run.events:
        channels.event(start_ns + event.t_ns, event.kind, event.text)
    return len(times_ns)


def _measured(run: Run, known: KnownRobot, channels: RobotChannels, start_ns: int) -> None:
    """Positions from three good ranges, brought to the times of the first sensor."""
    sensors = known.robot.sensors
    if sensors is None or any(axis not in run.readings for axis in AXES):
        return
    good = {axis: run.readings[axis].where(run.readings[axis].good) for axis in AXES}
    if any(len(readings.t_ns) < 2 for readings in good.values()):
        return
    t_ns = good[AXES[0]].t_ns
    ranges = np.stack([np.interp(t_ns, good[axis].t_ns, good[axis].distance_m) for axis in AXES])
    places = np.linalg.solve(sensors.axes, ranges - sensors.offsets_m[:, None]).T
    for when_ns, place in zip(t_ns.tolist(), places.tolist(), strict=True):
        channels.measured(start_ns + when_ns, (place[0], place[1], place[2]))


LOOK_S = 0.02
TITLE = "deltactl"


class LiveServer:
    """Hands every new status on. Raises ServiceError when the port is taken."""

    def __init__(self, link: DaemonLink, known_robots: KnownRobots, host: str, port: int):
        self._link, self._known_robots = link, known_robots
        self._context = foxglove.Context()
        self._channels: dict[str, RobotChannels] = {}
        self._last, self._state = -1, ""
        try:
            self._server = foxglove.start_server(
                name=TITLE, host=host, port=port, context=self._context
            )
        except (OSError, RuntimeError) as error:
            raise ServiceError(f"cannot listen at {host}:{port}: {error}") from error

    @property
    def port(self) -> int:
        """Where it listens."""
        return int(self._server.port)

    def look(self) -> bool:
        """Hand on what is new; whether there was anything."""
        seen = self._link.seen
        if seen.serial == self._last or seen.status is None:
            return False
        self._last = seen.serial
        self._send(seen.status)
        return True

    def close(self) -> None:
        """End the server."""
        self._server.stop()

    def _send(self, status: Status) -> None:
        known = self._known_robots.of(status.robot)
        if known is None:
            return
        if status.robot not in self._channels:
            self._channels[status.robot] = RobotChannels(known, self._context)
        channels, now_ns = self._channels[status.robot], time.time_ns()
        channels.counts(now_ns, status.counts)
        for sensor in status.sensors:
            if sensor.distance_m is not None and sensor.gate == "good":
                channels.range(now_ns, sensor.axis, sensor.distance_m)
        if status.target_m is not None:
            channels.pose(now_ns, "target", status.target_m)
        if (measured := known.measured(status.sensors)) is not None:
            channels.measured(now_ns, measured)
        if status.state != self._state:
            self._state = status.state
            channels.event(now_ns, status.state, f"{status.state} {status.why}".strip())


def serve_live(socket: Path | None, robot: Path, host: str, port: int) -> None:
    """Serve until Ctrl-C."""
    link = DaemonLink(socket)
    link.start()
    server = LiveServer(link, KnownRobots(robot), host, port)
    try:
        while True:
            if not server.look():
                time.sleep(LOOK_S)
    except KeyboardInterrupt:
        return
    finally:
        server.close()
        link.close()
