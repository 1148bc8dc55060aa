"""Words of the reference: the unit of every key that is a number, columns, requests."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from deltactl.firmware_py.daemon.connection import USUAL_WATCH_HZ

BY_SUFFIX = {name: name for name in ("m", "mm", "rad", "s", "ms", "us", "kg", "days")} | {
    "deg": "degrees",
    "hz": "Hz",
    "n": "N",
    "nm": "N m",
    "a": "A",
    "gib": "GiB",
    "radps": "rad/s",
    "radps2": "rad/s2",
    "mps": "m/s",
    "nmpa": "N m/A",
    "kgm2": "kg m2",
    "nmsprad": "N m s/rad",
    "1ps": "1/s",
    "1ps2": "1/s2",
    "mcps": "Mcps",
    "pin": "BCM number",
    "pins": "BCM numbers",
    **dict.fromkeys(("scale", "ratio", "fraction"), "ratio"),
}

BY_KEY = {
    "pin": "BCM number",
    "turns": "turns",
    "repeats": "count",
    "repeat": "count",
    "retries": "count",
    "count": "count",
    "skip_lines": "count",
    "seed": "any number",
    "microsteps_per_rev": "count",
    "zero_count": "count",
    "singularity_margin": "sine",
    "correlation": "ratio",
    "probability": "ratio",
    "axis": "ratio",
    "chip": "number of a chip",
    "bus": "number of a bus",
    "addresses": "7-bit address",
    "joint": "number of a joint",
    "inertia": "kg m2 or kg",
    "effort_gain": "N m or N",
    "drive_stiffness": "N m/rad or N/m",
    "parameters": "SI units",
    "ci95": "SI units",
    "spread": "SI units",
    "scale": "ratio",
    "offset": "SI units",
    "value": "SI units",
}

BOUNDED_ELSEWHERE = dict.fromkeys(("parameters", "ci95", "spread"), "those of the effect")
"""Numbers whose bounds depend on another key."""


def unit_of(key: str) -> str:
    """The unit of a key; empty where its name tells none."""
    return BY_KEY.get(key) or (BY_SUFFIX.get(key.rsplit("_", 1)[-1], "") if "_" in key else "")


_NUMBERED = re.compile(r"_[123xyz]$")

COLUMN_WORDS: dict[str, tuple[float, str]] = {
    "t": (0.02, "time"),
    "steps": (1840, "commanded count of the motor, 0 where its arm is level"),
    "command": (0.52, "commanded position of the arm or axis"),
    "range": (0.412, "reading of the distance sensor"),
    "status": (0, "0 marks a valid reading"),
    "theta": (0.523, "measured angle of the arm"),
    "pos": (0.05, "platform position, measured from outside"),
    "t_pwm": (0.006, "step period in force"),
    "current": (0.35, "current of the servo drive"),
    "disturbance": (0.02, "current added by the disturbance observer"),
    "temp_c": (23.5, "temperature of the machine"),
    "position": (0.523, "measured position of the axis"),
    "effort": (1.2, "torque, force or current of the drive"),
    "velocity": (0.8, "speed of the axis; by default derived from its position"),
    "load": (4.9, "external load on the axis; above 0 it pushes to larger positions"),
    "distance": (0.4, "true distance"),
    "segment": (0, "number of the run; a new number starts a new run"),
}
"""By name, without the number of the motor or the sensor's letter."""


def stem_of(column: str) -> str:
    """A column's name without its number or letter."""
    return _NUMBERED.sub("", column)


_JOB = "robot: zhao-2023.yaml\nname: circle\n"
_ROBOT = "kind: delta\nname: my-delta\n"

REQUEST_WORDS = {
    "ping": "Check that the controller runs.",
    "version": "Versions of the program, of Python and of the protocol.",
    "on": "Switch the drives on.",
    "off": "Switch the drives off; drops planned and queued jobs and a homing.",
    "home": "Home the arms. Ends with the connection.",
    "run": "Check a job and queue it. Ends with the connection unless `detach` is set.",
    "pause": "Slow down to rest on the path; hold a job that has not begun.",
    "resume": "Continue after a pause.",
    "cancel": "End a job in any phase, or a homing.",
    "stop": "Stop at once; acknowledge and home before you continue.",
    "acknowledge": "Clear a stop or a fault.",
    "status": "Report the state of the robot.",
    "sensors": "Report the readings of the distance sensors.",
    "watch": "Report the status repeatedly.",
    "result": "Report the result of a job.",
    "rename": "Give a recording in the daemon's folder another name.",
    "delete": "Delete a recording in the daemon's folder.",
    "move": "Give a waiting job another place in the queue.",
    "log": "Report the newest lines of the daemon's log.",
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
        "Accepted error of an arm that the sensors cannot see, after somebody has looked",
        40.0,
        0.0,
        "degrees",
    ),
    "robot": ArgumentWords(
        "Absolute path of another file of this machine", "/var/lib/deltactl/my-delta.yaml"
    ),
    "robot_text": ArgumentWords("Its text instead of a path", _ROBOT),
    "trial": ArgumentWords("That file is in force until this connection ends", True, False),
    "job": ArgumentWords("Absolute path of the job", "/var/lib/deltactl/circle.yaml"),
    "job_text": ArgumentWords("Its text instead of a path", _JOB),
    "name": ArgumentWords(
        "Name of the text in messages; by default `job.yaml` or `robot.yaml`. In `rename` the new "
        "name",
        "circle.yaml",
    ),
    "record": ArgumentWords(
        "Name of the recording; by default the job's name and the time", "first-circle.mcap"
    ),
    "job_id": ArgumentWords("Number of a job from `run`; `cancel` without it cancels all jobs", 7),
    "recording": ArgumentWords("Name of a recording in the daemon's folder", "circle.mcap"),
    "place": ArgumentWords("Place in the queue; 1 is the next to run", 1),
    "after": ArgumentWords("Number of the newest line that the client has", 120, 0),
    "detach": ArgumentWords("The job continues when the connection ends", True, False),
    "reason": ArgumentWords("Reason for the log", "the gripper is jammed", "stop requested"),
    "rate_hz": ArgumentWords("Rate of updates", 5.0, USUAL_WATCH_HZ, "Hz"),
}
