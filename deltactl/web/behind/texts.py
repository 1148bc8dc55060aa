"""Job and robot files as browsers send them: what they may name, and whose robot they are for."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from deltactl.firmware_py.job_file import JobFile
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.errors import ConfigError, DeltactlError
from deltactl.foundation.strict_yaml import Document
from deltactl.foundation.yaml_tree import Location
from deltactl.web.behind.known_robots import KnownRobot
from deltactl.web.behind.own_jobs import MAX_CHARACTERS
from deltactl.web.behind.site import Site

NAMING = ("robot", "record", "file", "include")
"""Keys of a job whose values name files, at any depth: steps have networks of their own."""


def kind_of(text: str) -> str:
    """'job' or 'robot'. Raises ConfigError for what a page may not send."""
    if len(text) > MAX_CHARACTERS:
        raise ConfigError(
            f"the text has {len(text):,} characters, and a page may send {MAX_CHARACTERS:,};"
            " put the file beside the daemon and use 'deltactl run'"
        )
    document = Document(Path("text"), text.replace("\r\n", "\n"))
    if "kind" in document.data and "path" not in document.data:
        return "robot"
    _refuse_paths(document, document.data, ())
    return "job"


LINE = re.compile(r"^[^\n:]*:(?P<line>\d+): ")


@dataclass(frozen=True, slots=True)
class Marked:
    """A mistake, and in which line of the text it is, from 1 on; 0 where that is not known."""

    line: int
    says: str


def mistakes(text: str, name: str) -> list[Marked]:
    """What is wrong with a job or robot file by itself, without a look at its robot.

    Raises nothing: it is asked while somebody types.
    """
    try:
        model = JobFile if kind_of(text) == "job" else RobotFile
        Document(Path(name), text.replace("\r\n", "\n")).check(model)
    except ConfigError as error:
        return [_marked(line) for line in str(error).splitlines()]
    except DeltactlError as error:
        return [_marked(str(error))]
    return []


def _marked(says: str) -> Marked:
    found = LINE.match(says)
    return Marked(int(found["line"]), says[found.end() :]) if found else Marked(0, says)


def _refuse_paths(document: Document, value: Any, place: Location) -> None:
    """A page names files of the project; it does not reach for others."""
    inner = enumerate(value) if isinstance(value, list) else ()
    for key, child in value.items() if isinstance(value, dict) else inner:
        here = (*place, key)
        if key in NAMING and isinstance(child, str) and _has_folder(child):
            raise document.fail(here, "a job from the page names files without folders")
        _refuse_paths(document, child, here)


def _has_folder(name: str) -> bool:
    return "/" in name or "\\" in name or name.startswith(".")


def of_another_robot(site: Site, name: str, text: str) -> str:
    """Which robot a job is for, and what to do, in one line; empty where it is for this one.

    name: of the job, as it is shown. Raises ConfigError for a text that is no YAML.
    """
    status = site.link.seen.status
    known = site.known(site.link.seen)
    wanted = Document(Path(name), text.replace("\r\n", "\n")).data.get("robot")
    if status is None or known is None or not isinstance(wanted, str) or wanted == known.file:
        return ""
    theirs = site.files().get(wanted)
    if theirs is not None and same_machine(known, theirs):
        return ""
    page = "deltactl web --simulate --robot" if status.simulated else "the daemon with"
    there = "" if theirs is not None else ", a file that is not here"
    return (
        f"{name} is a job for another robot: {wanted}{there}. This one is {known.file}. To run"
        f" the job on it, write 'robot: {known.file}' in the job; to run it on the robot it is"
        f" for, start {page} {wanted}."
    )


def same_machine(known: KnownRobot, theirs: Path) -> bool:
    """Whether a robot file describes the machine that runs here."""
    try:
        return known.robot.is_machine_of(KnownRobot.of(theirs).robot)
    except DeltactlError:
        return False
