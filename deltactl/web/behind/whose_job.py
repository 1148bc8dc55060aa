"""Whether a job is for the robot that runs here, and what to do where it is for another."""

from __future__ import annotations

from pathlib import Path

from deltactl.foundation.errors import DeltactlError
from deltactl.foundation.strict_yaml import Document
from deltactl.web.behind.belief import Belief
from deltactl.web.behind.site import Site


def of_another_robot(site: Site, name: str, text: str) -> str:
    """Which robot a job is for, and what to do, in one line; empty where it is for this one.

    name: of the job, as it is shown. Raises ConfigError for a text that is no YAML.
    """
    status = site.link.seen.status
    belief = site.belief(site.link.seen)
    wanted = Document(Path(name), text.replace("\r\n", "\n")).data.get("robot")
    if status is None or belief is None or not isinstance(wanted, str) or wanted == belief.file:
        return ""
    theirs = site.files().get(wanted)
    if theirs is not None and same_machine(belief, theirs):
        return ""
    page = "deltactl web --simulate --robot" if status.simulated else "the daemon with"
    there = "" if theirs is not None else ", a file that is not here"
    return (
        f"{name} is a job for another robot: {wanted}{there}. This one is {belief.file}. To run"
        f" the job on it, write 'robot: {belief.file}' in the job; to run it on the robot it is"
        f" for, start {page} {wanted}."
    )


def same_machine(belief: Belief, theirs: Path) -> bool:
    """Whether a robot file describes the machine that runs here."""
    try:
        return belief.robot.is_machine_of(Belief.of(theirs).robot)
    except DeltactlError:
        return False
