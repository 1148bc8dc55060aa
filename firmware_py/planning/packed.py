"""A plan as bytes: arrays as they lie in memory, and a line of JSON that says what they are.

Only the classes named here come out of it, and nothing in it is ever run. Arrays that come
out are views into the block: a million targets are there at once, without a copy.
"""

from __future__ import annotations

import json
from dataclasses import asdict, fields
from mmap import mmap
from pathlib import Path
from typing import Any

import numpy as np

from deltactl.firmware_py.file_access import FileAccess
from deltactl.firmware_py.job_file import JobFile
from deltactl.firmware_py.paths.path import Space
from deltactl.firmware_py.paths.reach import Reach
from deltactl.firmware_py.planner.curve import Curve
from deltactl.firmware_py.planner.plan import Plan, TimedLap
from deltactl.firmware_py.planner.targets import Lap
from deltactl.firmware_py.planner.timing_accelerated import CurveSchedule
from deltactl.firmware_py.planner.timing_moves import MotorLimits, MoveSchedule, TogetherSchedule
from deltactl.firmware_py.planning.prepared import InForce, Prepared, kinematics_for
from deltactl.firmware_py.program.instructions import (
    Block,
    Instruction,
    Move,
    Pause,
    Program,
    SetOutputs,
    Wait,
    WaitFor,
)
from deltactl.foundation.errors import ServiceError

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
SIMPLE: dict[str, Any] = {one.__name__: one for one in (SetOutputs, Wait, WaitFor, Pause)}
"""Instructions that are their own values."""
NO_PATH = {"shape": "joints", "angles_deg": [[0.0, 0.0, 0.0]]}
"""What a plan no longer needs is not sent: the targets are in its laps."""


OWN = ("job", "robot", "kinematics", "first", "again")
REST = tuple(one.name for one in fields(Plan) if one.name not in OWN)
"""Whatever else a plan has."""


def pack(prepared: Prepared) -> bytes:
    """Everything of a program but the robot, which both sides have."""
    program, arrays = prepared.program, Arrays()
    plans = list(program.plans())
    numbers = {id(plan): number for number, plan in enumerate(plans)}
    message = {
        "job": _without_path(program.job),
        "steps": program.job.steps is not None,
        "plans": [_plan_message(plan, arrays) for plan in plans],
        "whole": _instruction_message(program.whole, numbers),
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


def unpack(
    block: bytes | mmap, robot: InForce, job_file: Path, access: FileAccess | None = None
) -> Prepared:
    """The plan again; a network is opened anew.

    Raises ServiceError when that is no plan, and what a network raises.
    """
    try:
        length = int.from_bytes(block[:HEAD_BYTES], "little")
        content = json.loads(block[HEAD_BYTES : HEAD_BYTES + length])
        start = -(-(HEAD_BYTES + length) // ALIGNED) * ALIGNED
        views = [
            np.frombuffer(block, np.dtype(kind), _count(shape), start + offset).reshape(shape)
            for kind, shape, offset in content["arrays"]
        ]
        message = content["message"]
        text = bytes(_build(message["job_text"], views)).decode()
        job = _job(message["job"])
        if message["steps"]:
            job = job.model_copy(update={"path": None, "steps": ()})
        unlinked = [_unlinked_plan(one, views) for one in message["plans"]]
    except (ValueError, KeyError, TypeError, IndexError) as error:
        raise ServiceError(f"{job_file}: the planner's answer cannot be read ({error})") from error
    how = access or FileAccess()
    plans = [
        Plan(
            one, robot.robot, kinematics_for(one, robot.robot, job_file, how), first, again, **rest
        )
        for one, first, again, rest in unlinked
    ]
    try:
        whole = _instruction(message["whole"], plans)
    except (ValueError, KeyError, TypeError, IndexError) as error:
        raise ServiceError(f"{job_file}: the planner's answer cannot be read ({error})") from error
    assert isinstance(whole, Block)
    return Prepared(Program(job, robot.robot, whole), text)


def _without_path(job: JobFile) -> dict[str, Any]:
    return job.model_dump(mode="json", exclude={"path", "steps"}) | {"path": NO_PATH}


def _job(message: Any) -> JobFile:
    return JobFile.model_validate_json(json.dumps(message))


def _plan_message(plan: Plan, arrays: Arrays) -> dict[str, Any]:
    return {
        "job": _without_path(plan.job),
        "first": arrays.put(plan.first),
        "again": None if plan.again is None else arrays.put(plan.again),
        "closed": plan.again is plan.first,
        "rest": {name: arrays.put(getattr(plan, name)) for name in REST},
    }


def _unlinked_plan(message: Any, views: list[np.ndarray[Any, Any]]) -> tuple[Any, Any, Any, Any]:
    """Job, laps and the rest of a plan, which still lacks its kinematics."""
    first = _build(message["first"], views)
    again = None if message["again"] is None else _build(message["again"], views)
    rest = {name: _build(message["rest"][name], views) for name in REST}
    return _job(message["job"]), first, first if message["closed"] else again, rest


def _instruction_message(one: Instruction, numbers: dict[int, int]) -> dict[str, Any]:
    if isinstance(one, Move):
        return {"kind": "Move", "plan": numbers[id(one.plan)]}
    if isinstance(one, Block):
        steps = [_instruction_message(inner, numbers) for inner in one.steps]
        return {"kind": "Block", "count": one.count, "steps": steps}
    return {"kind": type(one).__name__} | asdict(one)


def _instruction(message: Any, plans: list[Plan]) -> Instruction:
    values = {name: value for name, value in message.items() if name != "kind"}
    kind = message["kind"]
    if kind == "Move":
        return Move(plans[values["plan"]])
    if kind == "Block":
        inner = tuple(_instruction(one, plans) for one in values["steps"])
        return Block(values["count"], inner)
    made: Instruction = SIMPLE[kind](**values)
    return made


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
