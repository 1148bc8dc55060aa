"""Every bound of the two configuration files says why it is there."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from annotated_types import Ge, Gt, Le, Lt, MaxLen, MinLen
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from deltactl.firmware_py.job_file import JobFile
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.models.robot import RangeSensor, ServoAxis, StepperAxis

UPPER_AND_LOWER = (Ge, Gt, Le, Lt)
NAMES = {"name", "robot", "file", "record", "include"}
"""Texts: a bound on their length needs no reason."""


def bounded(
    annotated: Any, inherited: str | None, path: str, above: tuple[type, ...] = ()
) -> Iterator[tuple[str, str | None]]:
    """Each bounded piece of an annotation with the reason that a message would give."""
    metadata = (
        annotated.metadata
        if isinstance(annotated, FieldInfo)
        else getattr(annotated, "__metadata__", ())
    )
    own = [getattr(annotated, "description", None)]
    own += [one.description for one in metadata if isinstance(one, FieldInfo)]
    inner = [each for one in metadata for each in getattr(one, "metadata", (one,))]
    reason = next(filter(None, own), inherited)
    if any(isinstance(one, (*UPPER_AND_LOWER, MaxLen, MinLen)) for one in inner):
        yield path, reason
    kind = annotated.annotation if isinstance(annotated, FieldInfo) else annotated
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        for name, field in kind.model_fields.items():
            if name not in NAMES and kind not in above:  # steps may hold steps
                yield from bounded(field, None, f"{path}.{name}", (*above, kind))
        return
    for part in getattr(kind, "__args__", ()):
        yield from bounded(part, reason, path, above)


@pytest.mark.parametrize("model", [RobotFile, JobFile, ServoAxis, StepperAxis, RangeSensor])
def test_each_bound_gives_its_reason(model: type[BaseModel]) -> None:
    found = list(bounded(model, None, model.__name__))
    assert not [path for path, reason in found if not reason]


def test_there_are_bounds_to_look_at() -> None:
    assert len(list(bounded(RobotFile, None, "robot"))) > 20
