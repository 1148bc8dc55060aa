"""A recorded run as MCAP with ROS 2 messages, which Foxglove and rviz show.

The file has the layout of a rosbag2 file: profile `ros2`, CDR messages, their definitions, and what
quality of service each topic was offered with. ROS need not be installed.

| topic | message | what |
|---|---|---|
| /robot_description | std_msgs/String | the URDF, once, kept for late subscribers |
| /joint_states | sensor_msgs/JointState | places and speeds of all joints that do not mimic |
| /tf | tf2_msgs/TFMessage | every link in its parent |
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any

import numpy as np

from deltactl.firmware_py.exporting.links import BASE, Joint, joints_of, places
from deltactl.firmware_py.exporting.urdf import urdf_text
from deltactl.firmware_py.robot_file import RobotFile, robot_in
from deltactl.foundation.errors import RecordingError
from deltactl.foundation.extras import needs
from deltactl.foundation.plain_file import said_of_output, whole_file
from deltactl.foundation.strict_yaml import Document
from deltactl.models.robot import FloatArray
from deltactl.recording.reading.run import Int64Array, Run

PERIOD_NS = 20_000_000
"""Between two messages of a topic: as the rounds of the sensors."""
NS_PER_S = 1_000_000_000
DESCRIPTION, JOINTS, FRAMES = "/robot_description", "/joint_states", "/tf"
TYPES = {
    DESCRIPTION: "std_msgs/msg/String",
    JOINTS: "sensor_msgs/msg/JointState",
    FRAMES: "tf2_msgs/msg/TFMessage",
}
LONGEST = "{sec: 9223372036, nsec: 854775807}"
LATE, NOT_LATE = 1, 2
"""rosbag2's durability: whether late subscribers get what was sent before they came."""


def export_ros2(run: Run, out: Path) -> int:
    """Write a run as MCAP with ROS 2 messages; returns how many states of the robot it holds.

    Angles are those that were commanded up to then (of servos: measured), through the robot file
    that the run carries. Raises ConfigError where that cannot be read, RecordingError where
    nothing moved or the file cannot be written, MissingExtra.
    """
    with needs("diagnosis", "export to ROS 2"):
        from mcap.writer import Writer
        from rosbags.typesys import Stores, get_typestore

    robot = robot_in(Document(run.path, run.configuration.robot_text))
    t_ns, angles_rad = _angles(run, robot)
    joints, found = joints_of(robot), places(robot, angles_rad)
    good = np.isfinite(np.stack(list(found.values()))).all(axis=0)
    if not good.any():
        raise RecordingError(f"{run.path}: nothing was commanded that the robot could reach")
    t_ns, found = t_ns[good], {name: values[good] for name, values in found.items()}
    types = get_typestore(Stores.ROS2_HUMBLE)
    with said_of_output(out), whole_file(out) as stream:
        writer = _Topics(Writer, stream, types)
        start_ns = run.configuration.start_epoch_ns
        first_ns = start_ns + int(t_ns[0])
        writer.add(DESCRIPTION, first_ns, types.types[TYPES[DESCRIPTION]](data=urdf_text(robot)))
        for topic, at_ns, message in _messages(types, joints, found, start_ns + t_ns):
            writer.add(topic, at_ns, message)
        writer.finish()
    return len(t_ns)


def _angles(run: Run, robot: RobotFile) -> tuple[Int64Array, FloatArray]:
    """Times [ns] and commanded or, of servos, measured arm angles [rad], (n, 3)."""
    if len(run.servo.t_ns):
        chosen = np.unique(run.servo.t_ns // PERIOD_NS, return_index=True)[1]
        return run.servo.t_ns[chosen], run.servo.angle_rad[chosen]
    times = [run.commanded.t_ns, run.edges.t_ns]
    known = np.concatenate([one for one in times if len(one)] or [np.zeros(0, dtype=np.int64)])
    if not len(known):
        raise RecordingError(f"{run.path}: nothing was commanded")
    t_ns = np.arange(int(known.min()), int(known.max()) + PERIOD_NS, PERIOD_NS, dtype=np.int64)
    return t_ns, run.edges.counts_at(t_ns) * robot.drive.rad_per_step


class _Topics:
    """A rosbag2 file that is written message by message."""

    def __init__(self, writer: Any, stream: IO[bytes], types: Any):
        self._writer, self._types, self._channels = writer(stream), types, dict[str, int]()
        self._writer.start(profile="ros2", library="deltactl")

    def add(self, topic: str, at_ns: int, message: Any) -> None:
        """One message, as CDR."""
        kind = TYPES[topic]
        if topic not in self._channels:
            self._channels[topic] = self._channel(topic, kind)
        data = bytes(self._types.serialize_cdr(message, kind))
        self._writer.add_message(self._channels[topic], at_ns, data, at_ns)

    def _channel(self, topic: str, kind: str) -> int:
        definition = self._types.generate_msgdef(kind, ros_version=2)[0]
        schema = self._writer.register_schema(kind, "ros2msg", definition.encode())
        service = _service(*((1, LATE) if topic == DESCRIPTION else (10, NOT_LATE)))
        number: int = self._writer.register_channel(
            topic, "cdr", schema, metadata={"offered_qos_profiles": service}
        )
        return number

    def finish(self) -> None:
        """Write the index."""
        self._writer.finish()


def _service(depth: int, durability: int) -> str:
    """A quality of service in rosbag2's words: reliable, the last messages kept."""
    return (
        f"- {{history: 1, depth: {depth}, reliability: 1, durability: {durability},"
        f" deadline: {LONGEST}, lifespan: {LONGEST}, liveliness: 1,"
        f" liveliness_lease_duration: {LONGEST}, avoid_ros_namespace_conventions: false}}\n"
    )


def _messages(
    types: Any, joints: list[Joint], found: dict[str, FloatArray], at_ns: Int64Array
) -> Iterator[tuple[str, int, Any]]:
    """Topic, time and message, in the order of their times."""
    time, header, state = (
        types.types[name]
        for name in ("builtin_interfaces/msg/Time", "std_msgs/msg/Header", TYPES[JOINTS])
    )
    names = [joint.name for joint in joints if joint.about is not None and not joint.mimics]
    rows = np.stack([found[name] for name in names], axis=1)
    speeds = np.gradient(rows, at_ns * 1e-9, axis=0) if len(rows) > 1 else np.zeros_like(rows)
    nothing = np.zeros(0)
    for row, now_ns in enumerate(at_ns.tolist()):
        stamp = time(sec=now_ns // NS_PER_S, nanosec=now_ns % NS_PER_S)
        moved = {"position": rows[row], "velocity": speeds[row], "effort": nothing}
        yield JOINTS, now_ns, state(header=header(stamp=stamp, frame_id=""), name=names, **moved)
        here = {name: float(values[row]) for name, values in found.items()}
        base = header(stamp=stamp, frame_id=BASE)
        transforms = [_transform(types, joint, here.get(joint.name, 0.0), base) for joint in joints]
        yield FRAMES, now_ns, types.types[TYPES[FRAMES]](transforms=transforms)


def _transform(types: Any, joint: Joint, place_rad: float, header: Any) -> Any:
    """Where a joint's child is in its parent."""
    made = {name: types.types[f"geometry_msgs/msg/{name}"] for name in MESSAGES}
    x, y, z = joint.origin_m
    qx, qy, qz, qw = turn(joint, place_rad)
    return made["TransformStamped"](
        header=type(header)(stamp=header.stamp, frame_id=joint.parent),
        child_frame_id=joint.child,
        transform=made["Transform"](
            translation=made["Vector3"](x=x, y=y, z=z),
            rotation=made["Quaternion"](x=qx, y=qy, z=qz, w=qw),
        ),
    )


MESSAGES = ("TransformStamped", "Transform", "Vector3", "Quaternion")


def turn(joint: Joint, place_rad: float) -> tuple[float, float, float, float]:
    """Its rotation as a quaternion x, y, z, w: first about z, then about the joint's own axis."""
    cz, sz = math.cos(joint.yaw_rad / 2.0), math.sin(joint.yaw_rad / 2.0)
    c, s = math.cos(place_rad / 2.0), math.sin(place_rad / 2.0)
    if joint.about is None:
        return 0.0, 0.0, sz, cz
    if joint.about == 0:
        return cz * s, sz * s, sz * c, cz * c
    return -sz * s, cz * s, sz * c, cz * c
