"""What a recording holds: one table of channels, from which schemas, writer and reader all work;
and channels with Foxglove's well-known schemas, which viewers draw without any set-up.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any, Literal

Schema = dict[str, Any]


def _object(title: str, **properties: Schema) -> Schema:
    return {"title": title, "type": "object", "properties": properties}


def _foxglove(name: str, /, **properties: Schema) -> Schema:
    return _object(f"foxglove.{name}", **properties)


def _several(items: Schema) -> Schema:
    return {"type": "array", "items": items}


NUMBER, INTEGER, TEXT, FLAG = (
    {"type": kind} for kind in ("number", "integer", "string", "boolean")
)
STAMP = _object("time", sec=INTEGER, nsec=INTEGER)
VECTOR = _foxglove("Vector3", x=NUMBER, y=NUMBER, z=NUMBER)
TURN = _foxglove("Quaternion", x=NUMBER, y=NUMBER, z=NUMBER, w=NUMBER)
POSE = _foxglove("Pose", position=VECTOR, orientation=TURN)
COLOUR = _foxglove("Color", r=NUMBER, g=NUMBER, b=NUMBER, a=NUMBER)
CYLINDER = _foxglove(
    "CylinderPrimitive", pose=POSE, size=VECTOR, bottom_scale=NUMBER, top_scale=NUMBER, color=COLOUR
)
EMPTY = {"type": "object", "properties": {}}
"""Foxglove refuses a channel with an object whose properties are not named."""
UNUSED = ("metadata", "arrows", "cubes", "spheres", "lines", "triangles", "texts", "models")
"""Lists of a scene's entity that have to be there, and are empty."""
_NAMED = {"timestamp": STAMP, "frame_id": TEXT}
_LISTS = {"cylinders": _several(CYLINDER)} | {part: _several(EMPTY) for part in UNUSED}
ENTITY = _foxglove("SceneEntity", **_NAMED, id=TEXT, lifetime=STAMP, frame_locked=FLAG, **_LISTS)
_BETWEEN = {"timestamp": STAMP, "parent_frame_id": TEXT, "child_frame_id": TEXT}
TRANSFORM = _foxglove("FrameTransform", **_BETWEEN, translation=VECTOR, rotation=TURN)
_BEAM = {"start_angle": NUMBER, "end_angle": NUMBER, "ranges": _several(NUMBER)}
_SAID = {"level": INTEGER, "message": TEXT, "name": TEXT, "file": TEXT, "line": INTEGER}
SCHEMAS: dict[str, Schema] = {
    schema["title"]: schema
    for schema in (
        _foxglove("FrameTransforms", transforms=_several(TRANSFORM)),
        _foxglove("SceneUpdate", deletions=_several(EMPTY), entities=_several(ENTITY)),
        _foxglove("PoseInFrame", **_NAMED, pose=POSE),
        _foxglove("LaserScan", **_NAMED, pose=POSE, **_BEAM, intensities=_several(NUMBER)),
        _foxglove("Log", timestamp=STAMP, **_SAID),
    )
}


@dataclass(frozen=True, slots=True)
class ViewedChannel:
    """One topic with the name of its schema."""

    topic: str
    schema_name: str

    def json_schema(self) -> bytes:
        """As MCAP stores it."""
        return json.dumps(SCHEMAS[self.schema_name]).encode()


TRANSFORMS = ViewedChannel("/tf", "foxglove.FrameTransforms")
SCENE = ViewedChannel("/robot", "foxglove.SceneUpdate")
POSES = {
    name: ViewedChannel(f"/pose/{name}", "foxglove.PoseInFrame")
    for name in ("target", "commanded", "measured")
}
RANGES = {axis: ViewedChannel(f"/range/{axis}", "foxglove.LaserScan") for axis in "xyz"}
LOG = ViewedChannel("/log", "foxglove.Log")

VIEWED: tuple[ViewedChannel, ...] = (TRANSFORMS, SCENE, *POSES.values(), *RANGES.values(), LOG)


FORMAT = 1
"""Version of this table; grows when a field changes its meaning. New fields do not count."""

SCHEMA_PREFIX = "deltactl."

WRITTEN_BY = "deltactl "
"""How the name of the writing program begins, in the header of a recording."""

MAGIC = b"\x89MCAP0\r\n"
"""First and last bytes of an MCAP file (MCAP specification, "Magic")."""

Kind = Literal["integer", "number", "string"]


@dataclass(frozen=True, slots=True)
class Field:
    """One field of a message; a `number` that has no value is left out."""

    name: str
    kind: Kind
    says: str


@dataclass(frozen=True, slots=True)
class Channel:
    """One topic with the fields of its messages."""

    topic: str
    schema: str
    says: str
    fields: tuple[Field, ...]

    @property
    def schema_name(self) -> str:
        """As MCAP knows it."""
        return SCHEMA_PREFIX + self.schema

    def json_schema(self) -> bytes:
        """JSON schema of a message, as MCAP stores it."""
        properties = {
            field.name: {"type": field.kind, "description": field.says} for field in self.fields
        }
        required = [field.name for field in self.fields if field.kind != "number"]
        schema = {
            "$schema": "https://json-schema.org/draft/2020-12/schema",
            "title": self.schema_name,
            "description": self.says,
            "type": "object",
            "properties": properties,
            "required": required,
        }
        return json.dumps(schema).encode()


def _fields(*rows: tuple[str, Kind, str]) -> tuple[Field, ...]:
    return tuple(Field(*row) for row in rows)


TIME: tuple[str, Kind, str] = ("t_ns", "integer", "run time [ns]")
STEPS: tuple[tuple[str, Kind, str], ...] = (
    ("steps_1", "integer", "signed count of motor 1 [microsteps]"),
    ("steps_2", "integer", "signed count of motor 2 [microsteps]"),
    ("steps_3", "integer", "signed count of motor 3 [microsteps]"),
)

TARGET = Channel(
    "/target",
    "Target",
    "A commanded position of the platform, and the counts calculated for it.",
    _fields(
        TIME,
        ("index", "integer", "number of the target in the job, from 0"),
        ("x_m", "number", "robot frame [m]"),
        ("y_m", "number", "robot frame [m]"),
        ("z_m", "number", "robot frame [m]"),
        *STEPS,
    ),
)
COMMANDED = Channel(
    "/commanded",
    "Commanded",
    "Counts the controller had commanded by then (sent or still queued for that time).",
    _fields(TIME, *STEPS),
)
EDGES = Channel(
    "/edges",
    "Edges",
    "A block of step edges that really went out; exact, see docs/recordings.md for decoding.",
    _fields(
        ("t_ns", "integer", "run time of the first edge of the block [ns]"),
        ("count", "integer", "edges in the block; 0 = the counts were set to steps_i at t_ns"),
        ("steps_1", "integer", "count of motor 1 before the block [microsteps]"),
        ("steps_2", "integer", "count of motor 2 before the block [microsteps]"),
        ("steps_3", "integer", "count of motor 3 before the block [microsteps]"),
        ("delta_ns", "string", "base64 of uint32 little-endian: time since the edge before [ns]"),
        ("bits", "string", "base64 of uint8: bit i-1 = motor i stepped, bit i+2 = backwards"),
    ),
)
READING_FIELDS = _fields(
    ("t_ns", "integer", "middle of the time over which light was collected, run time [ns]"),
    ("axis", "string", "x, y or z"),
    ("distance_m", "number", "reported distance [m]"),
    ("status", "integer", "range status as the vendor's driver gives it, 0 = valid"),
    ("raw_status", "integer", "the chip's own status (masked with 0x1F), 9 = valid"),
    ("signal_mcps", "number", "return signal rate [million counts/s]"),
    ("ambient_mcps", "number", "ambient light rate [million counts/s]"),
    ("sigma_m", "number", "the sensor's own estimate of its standard deviation [m]"),
    ("stream_count", "integer", "the chip's sample counter; the same twice = stale"),
    ("gate", "string", "good, or why it may not be used: status, signal, sigma, jump"),
)
READINGS = {
    axis: Channel(
        f"/reading/{axis}", "Reading", "One sample of one distance sensor.", READING_FIELDS
    )
    for axis in ("x", "y", "z")
}
EVENT = Channel(
    "/event",
    "Event",
    "Something that happened: path_start, path_end, state changes, faults, sensor restarts.",
    _fields(
        TIME,
        ("kind", "string", "one word a program can look for"),
        ("text", "string", "one sentence for people"),
    ),
)
TRUTH = Channel(
    "/truth",
    "Truth",
    "Where the simulated robot really was; absent on a real robot.",
    _fields(
        TIME,
        ("x_m", "number", "platform, robot frame [m]"),
        ("y_m", "number", "platform, robot frame [m]"),
        ("z_m", "number", "platform, robot frame [m]"),
        ("theta_1_rad", "number", "angle of arm 1, 0 = horizontal, positive = down [rad]"),
        ("theta_2_rad", "number", "angle of arm 2 [rad]"),
        ("theta_3_rad", "number", "angle of arm 3 [rad]"),
    ),
)
SERVO = Channel(
    "/servo",
    "Servo",
    "Means over a stretch of a servo's loop, t_ns its middle; absent on a stepper robot.",
    _fields(
        TIME,
        ("reference_1_rad", "number", "commanded angle of arm 1 [rad]"),
        ("reference_2_rad", "number", "commanded angle of arm 2 [rad]"),
        ("reference_3_rad", "number", "commanded angle of arm 3 [rad]"),
        ("theta_1_rad", "number", "angle of arm 1 by its encoder [rad]"),
        ("theta_2_rad", "number", "angle of arm 2 by its encoder [rad]"),
        ("theta_3_rad", "number", "angle of arm 3 by its encoder [rad]"),
        ("current_1_a", "number", "commanded current of motor 1, positive = arm down [A]"),
        ("current_2_a", "number", "commanded current of motor 2 [A]"),
        ("current_3_a", "number", "commanded current of motor 3 [A]"),
        ("disturbance_1_a", "number", "current added by the disturbance observer of motor 1 [A]"),
        ("disturbance_2_a", "number", "current added by the disturbance observer of motor 2 [A]"),
        ("disturbance_3_a", "number", "current added by the disturbance observer of motor 3 [A]"),
    ),
)
SETTINGS = Channel(
    "/settings",
    "Settings",
    "What holds from this time on.",
    _fields(TIME, ("t_pwm_s", "number", "step period; left out where motors have their own [s]")),
)
PACE = Channel(
    "/pace",
    "Pace",
    "A pause, its end or a cancellation: from this time on the path is followed at another pace.",
    _fields(
        TIME,
        ("rate", "number", "pace there, as a part of the planned one, 0 to 1"),
        ("goal", "number", "pace after the ramp: 0 is at rest, 1 is as planned"),
        ("ramp_s", "number", "how long the pace changes evenly from one to the other [s]"),
    ),
)
CONFIGURATION = Channel(
    "/configuration",
    "Configuration",
    "What ran, written once at the start; also in the file's metadata and attachments.",
    _fields(
        TIME,
        ("format", "integer", "version of these channels"),
        ("robot_name", "string", "name in the robot file"),
        ("job_name", "string", "name in the job file"),
        ("version", "string", "version of deltactl"),
        ("start_epoch_ns", "integer", "wall clock at run time 0 [ns since 1970, UTC]"),
        ("simulated", "integer", "1 = the robot was simulated"),
        ("robot_text", "string", "the robot file as it stood"),
        ("job_text", "string", "the job file as it stood"),
        ("settings_json", "string", "further settings of the run, a JSON object"),
    ),
)

CHANNELS: tuple[Channel, ...] = (
    CONFIGURATION,
    SETTINGS,
    EVENT,
    TARGET,
    COMMANDED,
    EDGES,
    *READINGS.values(),
    TRUTH,
    SERVO,
    PACE,
)

WRITTEN: tuple[Channel | ViewedChannel, ...] = (*CHANNELS, *VIEWED)
"""All channels of a file: those that are read back, and those for viewers."""

CHANNEL_IDS: dict[str, int] = {
    channel.topic: number for number, channel in enumerate(WRITTEN, start=1)
}
