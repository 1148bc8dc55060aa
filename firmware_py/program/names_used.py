"""Other files, outputs and inputs that a job names and that are not there, before it is read on.

They are reported beside the job's other mistakes, each with file and line.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Iterator, Mapping
from itertools import islice
from pathlib import Path
from typing import Any

from deltactl.firmware_py.file_access import FileAccess
from deltactl.firmware_py.named_files import find
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.errors import ConfigError, MissingFile
from deltactl.foundation.explain import Mistake
from deltactl.foundation.strict_yaml import MOST_COUNTED, Document
from deltactl.foundation.yaml_tree import Location


def wrong_names(
    document: Document, how: FileAccess, robot: RobotFile | None = None
) -> list[Mistake]:
    """What the steps of a job name and what is not there.

    robot: whose outputs and inputs they may name; None: the one that the job names.
    """
    if "steps" not in document.data:
        return []
    robot = robot or _robot_of(document, how.named)
    found = _in_steps(document.data.get("steps"), ("steps",), document.path, robot, how)
    return list(islice(found, MOST_COUNTED))


def _robot_of(document: Document, how: FileAccess) -> RobotFile | None:
    """The robot that a job names; None where its file has mistakes of its own, reported later.

    So too where nobody may see the contents of that file.
    """
    named = document.data.get("robot")
    if not isinstance(named, str) or not how.quote:
        return None
    try:
        return how.robot(find(named, document.path, listing=how.follow))
    except ConfigError:
        return None


def _in_steps(
    steps: Any, place: Location, path: Path, robot: RobotFile | None, how: FileAccess
) -> Iterator[Mistake]:
    for number, one in enumerate(steps if isinstance(steps, list) else ()):
        if not isinstance(one, dict):
            continue
        here = (*place, number)
        if isinstance(name := one.get("include"), str):
            yield from _include(name, (*here, "include"), path, how)
        if robot is not None:
            yield from _lines(one, here, robot)
        yield from _in_steps(one.get("steps"), (*here, "steps"), path, robot, how)
        if isinstance(inner := one.get("job"), dict):
            yield from _in_steps(inner.get("steps"), (*here, "job", "steps"), path, robot, how)


def _include(name: str, place: Location, path: Path, how: FileAccess) -> Iterator[Mistake]:
    if Path(name).is_absolute() or ".." in Path(name).parts:
        yield place, "name a file beside this job, or one of config/"
        return
    try:
        find(name, path, listing=how.follow)
    except MissingFile as error:
        yield place, str(error)


def _lines(one: Mapping[str, Any], here: Location, robot: RobotFile) -> Iterator[Mistake]:
    if isinstance(switched := one.get("set"), dict):
        for says in unknown(switched, robot.outputs, "outputs", robot):
            yield (*here, "set"), says
    awaited = one.get("wait_for")
    if isinstance(awaited, dict) and isinstance(name := awaited.get("input"), str):
        for says in unknown([name], robot.inputs.named, "inputs.named", robot):
            yield (*here, "wait_for"), says


def unknown(
    named: Iterable[str], known: Mapping[str, Any], section: str, robot: RobotFile
) -> Iterator[str]:
    """What to say of each name that a section of the robot file does not have."""
    for name in named:
        if name not in known:
            close = difflib.get_close_matches(name, known, n=1)
            there = ", ".join(known) or "none"
            hint = f"did you mean '{close[0]}'?" if close else f"it has {there}"
            yield f"'{name}' is not in '{section}' of robot '{robot.name}'; {hint}"
