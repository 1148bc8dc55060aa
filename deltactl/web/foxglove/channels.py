"""The topics, and the robot as messages on them. Times are nanoseconds since 1970."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

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

from deltactl.models.linkage import skeleton
from deltactl.models.linkage.skeleton import Placed, Skeleton
from deltactl.models.linkage.vectors import Vector
from deltactl.models.robot import AXES, FloatArray
from deltactl.web.behind.belief import Belief

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
"""Foxglove's cylinders stand along z, the drawing's links along their second column."""


class RobotChannels:
    """Writes the robot on its topics of one context."""

    def __init__(self, belief: Belief, context: Context):
        self._belief = belief
        self._skeleton = Skeleton.of(belief.robot.geometry)
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
        angles, position = self._belief.pose(tuple(int(count) for count in counts))
        transforms = [self._transform(t_ns, f"sensor_{axis}", *place)
                      for axis, place in self._sensors().items()]  # fmt: skip
        if position is not None:
            transforms.append(self._transform(t_ns, "platform", position, Quaternion(w=1.0)))
            self.pose(t_ns, "commanded", position)
        self._tf.log(FrameTransforms(transforms=transforms), log_time=t_ns)
        links = self._skeleton.links(angles, position)
        parts = [self._link(link, number) for number, link in enumerate(links)]
        cylinders = [one for some in parts for one in some] + self._plates(position)
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
        scan = LaserScan(timestamp=stamp(t_ns), frame_id=f"sensor_{axis}", pose=_pose((0, 0, 0)),
                         start_angle=0.0, end_angle=0.0, ranges=[distance_m],
                         intensities=[])  # fmt: skip
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
        described = self._belief.robot.sensors
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
        return FrameTransform(timestamp=stamp(t_ns), parent_frame_id=BASE, child_frame_id=child,
                              translation=_vector(place), rotation=rotation)  # fmt: skip

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
            made.append(CylinderPrimitive(pose=pose, size=size, bottom_scale=1.0, top_scale=1.0,
                                          color=colour))  # fmt: skip
        return made

    def _plates(self, position_m: Vector | None) -> list[CylinderPrimitive]:
        plates = [((0.0, 0.0, 0.03), self._skeleton.base_radius_m, DARK)]
        if position_m is not None:
            plates.append((position_m, self._skeleton.platform_radius_m, BLUE))
        return [
            CylinderPrimitive(pose=_pose(place), bottom_scale=1.0, top_scale=1.0, color=colour,
                              size=Vector3(x=2 * radius, y=2 * radius, z=PLATE_M))
            for place, radius, colour in plates
        ]  # fmt: skip


def stamp(t_ns: int) -> Timestamp:
    """A time of Foxglove."""
    return Timestamp(sec=t_ns // 1_000_000_000, nsec=t_ns % 1_000_000_000)


def quaternion(rotation: FloatArray) -> Quaternion:
    """Of a rotation matrix."""
    return _quaternion(skeleton.quaternion(rotation.tolist()))


def _quaternion(parts: tuple[float, float, float, float]) -> Quaternion:
    x, y, z, w = parts
    return Quaternion(x=x, y=y, z=z, w=w)


def _vector(point: Vector) -> Vector3:
    return Vector3(x=float(point[0]), y=float(point[1]), z=float(point[2]))


def _pose(point: Vector) -> Pose:
    return Pose(position=_vector(point), orientation=Quaternion(x=0.0, y=0.0, z=0.0, w=1.0))
