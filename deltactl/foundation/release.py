"""The version of the program, and what it still accepts from earlier versions.

What is to go warns for one release first, names what replaces it, and the release in which it goes;
a test fails when the version reaches that release with the entry still here.
"""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version

GONE_IN = "1.1"
"""The release in which all of the below goes: no version before 1.0 promised to keep it."""

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
