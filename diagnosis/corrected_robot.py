"""The corrected robot file: what was believed, and the effects that were found."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from diagnosis.result import Diagnosis, Finding
from foundation.errors import RecordingError
from foundation.strict_yaml import Document
from models.effects import VOCABULARY
from models.effects.lone_axis import command_effects, effort_effects, sensor_effects

_KINDS = {
    **command_effects("rotary"), **effort_effects("rotary"), **sensor_effects(), **VOCABULARY,
}  # fmt: skip
"""Every effect there is, of deltas, lone axes and lone sensors."""
HEADING = "# Found by deltactl diagnose; known from now on and part of the model."


def corrected_text(robot_file: Path, diagnosis: Diagnosis) -> str:
    """The robot file with every lasting, known finding as an entry of its `effects` section.

    Comments are kept unless the file had an `effects` section already. One-off events (lost
    steps, stale readings) and unknown mismatches are no property of the robot: left out.
    """
    document = Document.read(robot_file)
    entries = [_entry(finding) for finding in diagnosis.findings if _lasts(finding)]
    if not entries:
        return document.text
    if document.data.get("effects"):
        data = document.data | {"effects": [*document.data["effects"], *entries]}
        return f"{HEADING}\n{yaml.safe_dump(data, sort_keys=False)}"
    block = yaml.safe_dump({"effects": entries}, sort_keys=False)
    return f"{document.text.rstrip()}\n\n{HEADING}\n{block}"


def save_corrected(robot_file: Path, diagnosis: Diagnosis, out: Path) -> None:
    """Write the corrected robot file. Raises RecordingError when it exists or cannot be written."""
    try:
        with out.open("x", encoding="utf-8") as file:
            file.write(corrected_text(robot_file, diagnosis))
    except FileExistsError:
        raise RecordingError(f"{out}: exists already; choose another name") from None
    except OSError as error:
        raise RecordingError(f"{out}: cannot be written ({error.strerror})") from error


def _lasts(finding: Finding) -> bool:
    kind = VOCABULARY.get(finding.effect)
    if kind is None or kind.event:
        return False
    # A servo delta's friction is a torque here and a width there: only what the file can say.
    return set(finding.parameters) <= {parameter.name for parameter in kind.parameters}


def _entry(finding: Finding) -> dict[str, Any]:
    values = {name: one.value for name, one in finding.parameters.items()}
    return {"effect": finding.effect, "component": finding.component, "parameters": values}
