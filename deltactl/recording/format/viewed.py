"""What viewers draw without any set-up: channels with Foxglove's well-known schemas, as JSON.

A thinned copy, beside the channels that hold everything. Names and fields are those of Foxglove's
published schemas (docs.foxglove.dev, "Foxglove schemas"); only what is written here is listed.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

Schema = dict[str, Any]


def _object(title: str, **properties: Schema) -> Schema:
    return {"title": title, "type": "object", "properties": properties}


def _several(items: Schema) -> Schema:
    return {"type": "array", "items": items}


NUMBER, INTEGER, TEXT, FLAG = (
    {"type": kind} for kind in ("number", "integer", "string", "boolean")
)
TIME = _object("time", sec=INTEGER, nsec=INTEGER)
VECTOR = _object("foxglove.Vector3", x=NUMBER, y=NUMBER, z=NUMBER)
TURN = _object("foxglove.Quaternion", x=NUMBER, y=NUMBER, z=NUMBER, w=NUMBER)
POSE = _object("foxglove.Pose", position=VECTOR, orientation=TURN)
COLOUR = _object("foxglove.Color", r=NUMBER, g=NUMBER, b=NUMBER, a=NUMBER)
CYLINDER = _object("foxglove.CylinderPrimitive", pose=POSE, size=VECTOR, bottom_scale=NUMBER,
                   top_scale=NUMBER, color=COLOUR)  # fmt: skip
EMPTY = {"type": "object", "properties": {}}
"""Foxglove refuses a channel with an object whose properties are not named."""
UNUSED = ("metadata", "arrows", "cubes", "spheres", "lines", "triangles", "texts", "models")
"""Lists of a scene's entity that have to be there, and are empty."""
ENTITY = _object("foxglove.SceneEntity", timestamp=TIME, frame_id=TEXT, id=TEXT, lifetime=TIME,
                 frame_locked=FLAG, cylinders=_several(CYLINDER),
                 **{part: _several(EMPTY) for part in UNUSED})  # fmt: skip
TRANSFORM = _object("foxglove.FrameTransform", timestamp=TIME, parent_frame_id=TEXT,
                    child_frame_id=TEXT, translation=VECTOR, rotation=TURN)  # fmt: skip
SCHEMAS: dict[str, Schema] = {
    schema["title"]: schema
    for schema in (
        _object("foxglove.FrameTransforms", transforms=_several(TRANSFORM)),
        _object("foxglove.SceneUpdate", deletions=_several(EMPTY),
                entities=_several(ENTITY)),
        _object("foxglove.PoseInFrame", timestamp=TIME, frame_id=TEXT, pose=POSE),
        _object("foxglove.LaserScan", timestamp=TIME, frame_id=TEXT, pose=POSE,
                start_angle=NUMBER, end_angle=NUMBER, ranges=_several(NUMBER),
                intensities=_several(NUMBER)),
        _object("foxglove.Log", timestamp=TIME, level=INTEGER, message=TEXT, name=TEXT, file=TEXT,
                line=INTEGER),
    )
}  # fmt: skip


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
