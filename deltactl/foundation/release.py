"""The version of the program, and what it still accepts from earlier versions.

What is to go warns for one release first, names what replaces it, and the release in which it goes;
a test fails when the version reaches that release with the entry still here.
"""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version

GONE_IN = "1.1"
"""The release in which all of the below goes: no version before 1.0 promised to keep it."""

COMMANDS: dict[str, str] = {
    "diagnose --inspect": "inspect",
    "diagnose --fleet": "fleet",
    "demo --conceal": "demo --hide",
    "init --kind delta": "init delta",
    "init --kind servo_axis": "init axis",
    "init --kind stepper_axis": "init axis --drive stepper",
    "init --kind range_sensor": "init sensor",
    "init FILE": "init delta FILE",
    "verify": "job verify",
    "follow": "job follow",
    "pause": "job pause",
    "resume": "job resume",
    "cancel": "job cancel",
    "teach": "job teach",
    "on": "power on",
    "off": "power off",
    "record": "sensors record",
    "collect": "network collect",
    "train": "network train",
    "evaluate": "network evaluate",
    "prove": "demo prove",
    "reproduce": "network reproduce",
    "daemon": "service daemon",
    "install": "service install",
    "check-runs": "service check-runs",
    "web-user": "web user",
    "foxglove": "web foxglove",
    "version": "--version",
}
"""Commands of version 0.1, old to new, each without `deltactl`. Options in an old spelling may be
typed anywhere behind the command."""

OF_A_RESULT = ("job_id", "name", "outcome", "why", "recording", "recording_error", "warning")
"""What `simulate` returned in version 0.1."""
NAMES: dict[str, str] = {
    "Answer": "Diagnosis",
    "load_robot": "Robot.load(...), whose .model is what this returns",
    "read_recording": "read(...), whose .table is what this returns",
    "run": "Client().run(...)",
    "Diagnosis.save_robot(path)": "Diagnosis.corrected_robot().save(path)",
    **{f"simulate(...).{name}": f"simulate(...).ended.{name}" for name in OF_A_RESULT},
}
"""Names of version 0.1 in Python, old to new, each behind `deltactl.`"""


def own_version() -> str:
    """Version of the installed package, which every report and recording carries."""
    try:
        return version("deltactl")
    except PackageNotFoundError:
        return "unknown"
