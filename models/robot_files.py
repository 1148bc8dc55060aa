"""Robot files of any kind: reading them, and the names that an axis that slides has in its file.

Inside, and in the JSON of an answer, one effect has one vocabulary whatever its motion. A file is
read by people: a shift in m is no angle there, and a force in N no torque.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from deltactl.foundation.errors import ConfigError
from deltactl.foundation.strict_yaml import Document
from deltactl.models.chain.stated import forms_of, wrong_effects, wrong_values
from deltactl.models.effects import card_of
from deltactl.models.robot import (
    KINDS,
    MACHINE_SECTIONS,
    DeltaRobot,
    RangeSensor,
    RobotModel,
    ServoAxis,
    StepperAxis,
)


def load_robot_model(path: Path) -> RobotModel:
    """Read the model sections of a robot file; machine sections are left to firmware_py.

    Whether there are such effects is left to `load_with_effects`. Raises MissingFile or
    ConfigError, a line for each mistake with file, line and the nearest valid key.
    """
    document = Document.read(path)
    return document.check(kind_in(document), model_sections(document))


def load_with_effects(path: Path) -> RobotModel:
    """Read a robot file as `load_robot_model` does, and refuse effects that there are not.

    Raises MissingFile or ConfigError, a line for each mistake.
    """
    document = Document.read(path)
    kind, data = kind_in(document), model_sections(document)
    try:
        robot = document.check(kind, data)
    except ConfigError as error:
        forms = forms_of(str(data["kind"]), data.get("motion"))
        also = wrong_values(("effects",), data.get("effects"), forms)
        raise ConfigError(*error.args, *document.fail_all(also).args) from None
    if mistakes := list(wrong_effects(robot)):
        raise document.fail_all(mistakes)
    return robot


def kind_in(document: Document) -> type[DeltaRobot | StepperAxis | ServoAxis | RangeSensor]:
    """What kind of machine a file describes. Raises ConfigError where it describes none."""
    kind = document.data.get("kind")
    if kind is None and "robot" in document.data:
        named = document.data["robot"]
        raise document.fail(
            ("robot",), f"this is a job, and a robot file is needed here, such as {named}"
        )
    if kind not in KINDS:
        raise document.fail(("kind",), f"must be one of {', '.join(KINDS)} (got {kind!r})")
    return KINDS[kind]


def model_sections(document: Document) -> dict[str, Any]:
    """What a file says of the machine itself, with the names of effects that are used inside."""
    data = document.data
    return _inside({key: value for key, value in data.items() if key not in MACHINE_SECTIONS})


def _inside(data: dict[str, Any]) -> dict[str, Any]:
    """The data of a robot file; effects of an axis that slides have other names in the file."""
    entries = data.get("effects")
    if data.get("motion") != "linear" or not isinstance(entries, list):
        return data
    inside = [named_inside(entry) if isinstance(entry, dict) else entry for entry in entries]
    return data | {"effects": inside}


def load_delta(path: Path) -> DeltaRobot:
    """Read a robot file that must describe a delta. Raises ConfigError otherwise."""
    robot = load_robot_model(path)
    if not isinstance(robot, DeltaRobot):
        raise ConfigError(f"{path}: is a {robot.kind}; a delta robot is needed here")
    return robot


def named_for_file(entry: Mapping[str, Any]) -> dict[str, Any]:
    """An entry of `effects` with the names for a file."""
    return _renamed(entry, card_of(str(entry.get("effect"))).slide_names)


def named_inside(entry: Mapping[str, Any]) -> dict[str, Any]:
    """An entry of `effects` as it is inside; a file that has those names already is read too."""
    names = card_of(str(entry.get("effect"))).slide_names
    return _renamed(entry, {shown: name for name, shown in names.items()})


def _renamed(entry: Mapping[str, Any], names: Mapping[str, str]) -> dict[str, Any]:
    made = dict(entry)
    if isinstance(values := made.get("parameters"), dict):
        made["parameters"] = _keys(values, names)
    if isinstance(found := made.get("found"), dict) and isinstance(found.get("ci95"), dict):
        made["found"] = found | {"ci95": _keys(found["ci95"], names)}
    return made


def _keys(values: dict[str, Any], names: Mapping[str, str]) -> dict[str, Any]:
    """With other keys, in the same order; a key whose new name is there already is left."""
    return {
        key if names.get(key, key) in values else names[key]: value for key, value in values.items()
    }
