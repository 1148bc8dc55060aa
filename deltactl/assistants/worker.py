"""One inspection or diagnosis for an assistant, in a process of its own and at low priority.

`python -m deltactl.assistants.worker KIND REQUEST` takes the request as a JSON object, works in the
folder that it names as root, and writes one JSON object a line: {"progress": text} any number of
times, then {"result": {...}}, which is an answer or a refusal.
"""

from __future__ import annotations

import json
import os
import re
import sys
import traceback
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import deltactl as dc
from deltactl.assistants.allowed import inside, read_only, robot_file
from deltactl.assistants.refused import refused
from deltactl.foundation.errors import ForbiddenPath, RecordingError
from deltactl.web.behind.worker import NICE, write_line, write_progress

ROBOT_TEXT = "robot_text"
"""What messages call a robot file that was given as text."""
NAMED_FILE = re.compile(r"""\b(?:file|\w*dir)\s*=\s*["']([^"']*)""")
"""A file or folder that an XML model names."""
Request = Mapping[str, Any]


class Part:
    """The part of the work that is under way, and the columns that it is about."""

    def __init__(self) -> None:
        self.name = "recording"
        self.columns: list[str] = []

    @contextmanager
    def named(self, name: str) -> Iterator[None]:
        """A part of this name; an error in it leaves the name as it is."""
        before, self.name = self.name, name
        yield
        self.name = before


def inspect(root: Path, request: Request, part: Part) -> dict[str, Any]:
    """What a table holds. Raises any DeltactlError."""
    write_progress("reading")
    with part.named("columns" if request["columns"] else "recording"):
        seen = dc.inspect(inside(root, request["recording"]), request["columns"])
    unused = {name: seen.unused(name) for name in seen.table if name not in seen.guesses}
    return {
        "json": seen.to_json() | {"file": str(seen.path), "unused": unused},
        "own_run": seen.own_run,
        "needs_inertia": seen.needs_inertia,
        "zero": seen.zero,
        "kind_why": seen.kind_why,
    }


def diagnose(root: Path, request: Request, part: Part) -> dict[str, Any]:
    """Where recordings and a robot file differ. Raises any DeltactlError."""
    from deltactl.diagnosis.report.screen import sentences_by_topic

    columns = request["columns"]
    part.columns = [text.partition("=")[2].partition("[")[0] for text in columns or []]
    with part.named("robot_file"):
        robot = _robot(root, request)
    used, held_out = (
        _recordings([inside(root, named) for named in request[key]], columns, part)
        for key in ("recordings", "holdout")
    )
    diagnosis = dc.diagnose(used, robot, holdout=held_out, progress=write_progress)
    return {
        "json": diagnosis.to_json(),
        "says": sentences_by_topic(diagnosis.answer, diagnosis.robot.model),
    }


def _robot(root: Path, request: Request) -> dc.Robot:
    if text := request["robot_text"]:
        robot = dc.Robot.from_text(text, ROBOT_TEXT)
    else:
        robot = dc.Robot.load(robot_file(root, request["robot"]))
    if robot.model.kind == "chain":
        _refuse_files_elsewhere(root, robot)
    return robot


def _refuse_files_elsewhere(root: Path, robot: dc.Robot) -> None:
    """What a URDF or MJCF names is read by MuJoCo, and no look at Python's files sees it."""
    model = inside(root, str(robot.path.parent / robot.document.data["model"]))
    text = Path(model).read_text(encoding="utf-8", errors="replace")
    named = [Path(one) for one in NAMED_FILE.findall(text)]
    if "<include" in text or any(one.is_absolute() or ".." in one.parts for one in named):
        raise ForbiddenPath(
            f"{model}: names other files, which may lie anywhere; give a model that is whole in"
            " itself, with masses and inertias in place of meshes"
        )


def _recordings(paths: list[str], columns: list[str] | None, part: Part) -> list[dc.Recording]:
    """Those that can be read. Raises RecordingError where one is damaged, as it names it."""
    read = []
    for path in paths:
        write_progress("reading")
        with part.named("columns" if columns else "recording"):
            try:
                read.append(dc.read(path, columns))
            except RecordingError as error:
                part.columns += _headings(Path(path))
                raise error
    return read


def _headings(path: Path) -> list[str]:
    """The first line of a text table as names, so that a refusal can say which it is about."""
    if path.suffix != ".csv":
        return []
    with path.open(encoding="utf-8", errors="replace") as lines:
        first = lines.readline(10_000)
    return [name.strip().strip('"') for name in first.replace(";", ",").split(",")]


KINDS: dict[str, Callable[[Path, Request, Part], dict[str, Any]]] = {
    "inspect": inspect,
    "diagnose": diagnose,
}


def result(kind: str, request: Request, hold: Callable[[Path], None] = read_only) -> dict[str, Any]:
    """Do one piece of work: an answer, or a refusal. hold: keeps this process to the root."""
    root, part = Path(request["root"]).resolve(), Part()
    try:
        os.chdir(root)
        hold(root)
        return KINDS[kind](root, request, part)
    except Exception as error:
        refusal = refused(error, part.name, part.columns)
        if refusal.kind == "defect":
            traceback.print_exc()
        return refusal.to_json()


def main(arguments: list[str]) -> None:
    """Do one piece of work."""
    os.nice(NICE)
    kind, text = arguments
    write_line({"result": result(kind, json.loads(text))})


if __name__ == "__main__":
    main(sys.argv[1:])
