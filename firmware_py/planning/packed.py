"""A plan as bytes: arrays as they lie in memory, and a line of JSON that says what they are.

Only the classes named here come out of it, and nothing in it is ever run. Arrays that come
out are views into the block: a million targets are there at once, without a copy.
"""

from __future__ import annotations

import json
from dataclasses import fields
from mmap import mmap
from typing import Any

import numpy as np

from firmware_py.job_file import JobFile
from firmware_py.paths.path import Space
from firmware_py.paths.reach import Reach
from firmware_py.planner.curve import Curve
from firmware_py.planner.kinematics import kinematics_of
from firmware_py.planner.plan import Plan, TimedLap
from firmware_py.planner.targets import Lap
from firmware_py.planner.timing_accelerated import CurveSchedule
from firmware_py.planner.timing_moves import MotorLimits, MoveSchedule
from firmware_py.planner.timing_together import TogetherSchedule
from firmware_py.planning.prepared import InForce, Prepared
from foundation.errors import ServiceError

ALIGNED = 64
HEAD_BYTES = 16
CLASSES: dict[str, type] = {
    kind.__name__: kind
    for kind in (
        TimedLap,
        Lap,
        Reach,
        TogetherSchedule,
        MoveSchedule,
        CurveSchedule,
        Curve,
        MotorLimits,
    )
}
NO_PATH = {"shape": "joints", "angles_deg": [[0.0, 0.0, 0.0]]}
"""What a plan no longer needs is not sent: the targets are in its laps."""


OWN = ("job", "robot", "kinematics", "first", "again")
REST = tuple(one.name for one in fields(Plan) if one.name not in OWN)
"""Whatever else a plan has."""


def pack(prepared: Prepared) -> bytes:
    """Everything of a plan but the robot, which both sides have."""
    plan, arrays = prepared.plan, Arrays()
    job = plan.job.model_dump(mode="json") | {"path": NO_PATH}
    message = {
        "job": job,
        "first": arrays.put(plan.first),
        "again": None if plan.again is None else arrays.put(plan.again),
        "closed": plan.again is plan.first,
        "rest": {name: arrays.put(getattr(plan, name)) for name in REST},
        "job_text": arrays.put(np.frombuffer(prepared.job_text.encode(), dtype=np.uint8)),
    }
    head = json.dumps({"message": message, "arrays": arrays.index}).encode()
    start = -(-(HEAD_BYTES + len(head)) // ALIGNED) * ALIGNED
    whole = bytearray(start + arrays.size)
    whole[:HEAD_BYTES] = len(head).to_bytes(HEAD_BYTES, "little")
    whole[HEAD_BYTES : HEAD_BYTES + len(head)] = head
    for (_, _, offset), array in zip(arrays.index, arrays.found, strict=True):
        whole[start + offset : start + offset + array.nbytes] = array.tobytes()
    return bytes(whole)


def unpack(block: bytes | mmap, robot: InForce, job_file: Any) -> Prepared:
    """The plan again. Raises ServiceError when that is no plan, and what a network raises."""
    try:
        length = int.from_bytes(block[:HEAD_BYTES], "little")
        content = json.loads(block[HEAD_BYTES : HEAD_BYTES + length])
        start = -(-(HEAD_BYTES + length) // ALIGNED) * ALIGNED
        views = [
            np.frombuffer(block, np.dtype(kind), _count(shape), start + offset).reshape(shape)
            for kind, shape, offset in content["arrays"]
        ]
        message = content["message"]
        first = _build(message["first"], views)
        again = None if message["again"] is None else _build(message["again"], views)
        text = bytes(_build(message["job_text"], views)).decode()
        job = JobFile.model_validate_json(json.dumps(message["job"]))
        rest = {name: _build(message["rest"][name], views) for name in REST}
    except (ValueError, KeyError, TypeError, IndexError) as error:
        raise ServiceError(f"{job_file}: the planner's answer cannot be read ({error})") from error
    kinematics = kinematics_of(job, robot.robot, job_file)
    again = first if message["closed"] else again
    return Prepared(Plan(job, robot.robot, kinematics, first, again, **rest), text)


class Arrays:
    """Takes objects apart into plain values, and arrays beside them."""

    def __init__(self) -> None:
        self.found: list[np.ndarray[Any, Any]] = []
        self.index: list[tuple[str, list[int], int]] = []
        self.size = 0

    def put(self, value: Any) -> Any:
        """A value as JSON can say it."""
        if isinstance(value, np.ndarray):
            return {"array": self._add(value)}
        if isinstance(value, Space):
            return {"space": value.value}
        if isinstance(value, np.generic):
            return value.item()
        if isinstance(value, tuple):
            return {"tuple": [self.put(one) for one in value]}
        kind = type(value)
        if CLASSES.get(kind.__name__) is kind:
            return {"class": kind.__name__, "fields": self._fields(value)}
        return value

    def _fields(self, value: Any) -> dict[str, Any]:
        names = getattr(type(value), "__slots__", None) or vars(value)
        return {name: self.put(getattr(value, name)) for name in names}

    def _add(self, array: np.ndarray[Any, Any]) -> int:
        whole = np.ascontiguousarray(array)
        self.found.append(whole)
        self.index.append((whole.dtype.str, list(whole.shape), self.size))
        self.size += -(-whole.nbytes // ALIGNED) * ALIGNED
        return len(self.found) - 1


def _build(value: Any, views: list[np.ndarray[Any, Any]]) -> Any:
    if not isinstance(value, dict):
        return value
    if "array" in value:
        return views[value["array"]]
    if "space" in value:
        return Space(value["space"])
    if "tuple" in value:
        return tuple(_build(one, views) for one in value["tuple"])
    made: Any = object.__new__(CLASSES[value["class"]])
    for name, field in value["fields"].items():
        object.__setattr__(made, name, _build(field, views))
    return made


def _count(shape: list[int]) -> int:
    count = 1
    for size in shape:
        count *= size
    return count
