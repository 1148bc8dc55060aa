"""Requests of the socket and their arguments in words, with defaults and examples."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from deltactl.firmware_py.daemon.connection import USUAL_WATCH_HZ

_JOB = "robot: zhao-2023.yaml\nname: circle\n"
_ROBOT = "kind: delta\nname: my-delta\n"

REQUEST_WORDS = {
    "ping": "Whether the controller runs.",
    "version": "Versions of the program, of Python and of the protocol.",
    "on": "Switch the drives on.",
    "off": "Switch the drives off; what is planned, waits or homes is dropped.",
    "home": "Find out where the arms are. Ends with the connection.",
    "run": "Check a job and queue it. Ends with the connection, unless it is to `detach`.",
    "pause": "Slow down to a standstill on the path; a job that has not begun is held.",
    "resume": "Go on after a pause.",
    "cancel": "End a job on its path, before it begins, or while it is planned; or a homing.",
    "stop": "Stop at once; acknowledge and home before going on.",
    "acknowledge": "Leave a stop or a fault behind.",
    "status": "All that is known of the robot.",
    "sensors": "Readings of the ranging sensors.",
    "watch": "The status, again and again.",
    "result": "What became of a job.",
}


@dataclass(frozen=True, slots=True)
class ArgumentWords:
    """What an argument says; a default of None: nothing is taken in its place."""

    says: str
    example: Any
    default: Any = None
    unit: str = ""


ARGUMENT_WORDS = {
    "accept_unseen_deg": ArgumentWords(
        "By how much an arm may be off unseen; somebody has looked", 40.0, 0.0, "degrees"
    ),
    "robot": ArgumentWords(
        "Whole path of another file of this machine", "/var/lib/deltactl/my-delta.yaml"
    ),
    "robot_text": ArgumentWords("Its text, in place of a path", _ROBOT),
    "job": ArgumentWords("Whole path of the job", "/var/lib/deltactl/circle.yaml"),
    "job_text": ArgumentWords("Its text, in place of a path", _JOB),
    "name": ArgumentWords(
        "What a text is called in messages; absent: `job.yaml`, `robot.yaml`", "circle.yaml"
    ),
    "record": ArgumentWords(
        "Name of the recording; absent: that of the job and the time", "first-circle.mcap"
    ),
    "job_id": ArgumentWords("Number of a job, as `run` gave it; `cancel` without: all jobs", 7),
    "detach": ArgumentWords("The job goes on when the connection ends", True, False),
    "reason": ArgumentWords("Why, for the log", "the gripper is jammed", "stop requested"),
    "rate_hz": ArgumentWords("How often", 5.0, USUAL_WATCH_HZ, "Hz"),
}  # fmt: skip
