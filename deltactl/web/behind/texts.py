"""Job and robot files as browsers send them: what they may name, and whose robot they are for."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from deltactl.foundation.errors import ConfigError, DeltactlError
from deltactl.foundation.strict_yaml import Document
from deltactl.foundation.yaml_tree import Location
from deltactl.web.behind.known_robots import KnownRobot
from deltactl.web.behind.site import Site

MAX_CHARACTERS = 60_000
"""What the daemon takes of a job's text."""
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
