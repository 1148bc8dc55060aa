"""Robot files of any kind: reading them, and all that is wrong with the effects that they state.

Inside, and in the JSON of an answer, one effect has one vocabulary whatever its motion. A file is
read by people: a shift in m is no angle there, and a force in N no torque.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from deltactl.foundation.errors import ConfigError
from deltactl.foundation.strict_yaml import Document
from deltactl.foundation.yaml_tree import Location
from deltactl.models.chain.active import activate
from deltactl.models.effects import TABLES, VOCABULARY, card_of
from deltactl.models.effects.kind import EffectKind
from deltactl.models.effects.lone_axis import (
    Motion,
    command_effects,
    effort_effects,
    sensor_effects,
)
from deltactl.models.robot import (
    KINDS,
    MACHINE_SECTIONS,
    AnyKind,
    DeltaRobot,
    EffectEntry,
    RobotModel,
)

Forms = Mapping[str, Sequence[EffectKind]]
"""Effect -> what it may be: of an axis another thing with an effort column than with commands."""

MOTIONS: tuple[Motion, ...] = ("linear", "rotary")


def of_delta() -> Forms:
    """What a delta may have."""
    return {name: [kind] for name, kind in {**VOCABULARY, **TABLES}.items()}


def wrong_effects(robot: RobotModel) -> Iterator[tuple[Location, str]]:
    """Entries of `effects` that the vocabulary of such a machine does not have."""
    forms = forms_of(robot.kind, getattr(robot, "motion", None))
    yield from wrong_entries(("effects",), robot.effects, forms)


def wrong_values(place: Location, entries: Any, forms: Forms) -> Iterator[tuple[Location, str]]:
    """The same in the values of a file that has whatever other mistakes."""
    for index, one in enumerate(entries if isinstance(entries, list) else ()):
        try:
            entry = EffectEntry.model_validate(one, strict=False)
        except ValidationError:
            continue  # said already
        yield from (((*place, index), says) for _, says in wrong_entries((), (entry,), forms))


def wrong_entries(
    place: Location, entries: Sequence[EffectEntry], forms: Forms
) -> Iterator[tuple[Location, str]]:
    """Unknown effects, components and parameters, and values out of bounds, each where it is."""
    for index, entry in enumerate(entries):
        if says := _wrong(entry, forms):
            yield (*place, index), says


def forms_of(kind: str, motion: Any = None) -> Forms:
    """What effects a machine of this kind may have; none of an axis whose motion is not known."""
    if kind == "delta":
        return of_delta()
    if kind == "stepper_axis":
        return _together(command_effects("rotary"))
    if kind == "range_sensor":
        return _together(sensor_effects())
    if kind == "chain":
        return {}  # its plant knows the joints
    if motion not in MOTIONS:
        return {}
    vocabularies = command_effects(motion), effort_effects(motion)
    return _together(*map(_by_file, vocabularies) if motion == "linear" else vocabularies)


def _together(*vocabularies: Mapping[str, EffectKind]) -> Forms:
    names = sorted({name for kinds in vocabularies for name in kinds})
    return {name: [kinds[name] for kinds in vocabularies if name in kinds] for name in names}


def _by_file(kinds: Mapping[str, EffectKind]) -> Mapping[str, EffectKind]:
    """With the names that a file has for the parameters of an axis that slides."""
    return {name: _slide_named(kind, card_of(name).slide_names) for name, kind in kinds.items()}


def _slide_named(kind: EffectKind, names: Mapping[str, str]) -> EffectKind:
    named = tuple(replace(part, name=names.get(part.name, part.name)) for part in kind.parameters)
    return replace(kind, parameters=named)


def _wrong(entry: EffectEntry, forms: Forms) -> str:
    """What is wrong with an entry; empty where one of the forms of its effect takes it."""
    if not forms:
        return ""
    if entry.effect not in forms:
        return f"effect '{entry.effect}' must be one of {', '.join(sorted(forms))}"
    said = []
    for kind in forms[entry.effect]:
        known = {parameter.name for parameter in kind.parameters}
        names = {a: b for a, b in card_of(entry.effect).slide_names.items() if b in known}
        given = {names.get(name, name): value for name, value in entry.parameters.items()}
        try:
            activate(kind, entry.component, given)
        except ConfigError as error:
            said.append(str(error))
        else:
            return ""
    return said[0]


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
    return with_effects_in(Document.read(path))


def with_effects_in(document: Document) -> RobotModel:
    """The robot of a file that was read, as `load_with_effects`. Raises ConfigError."""
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


def kind_in(document: Document) -> AnyKind:
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
    data = {key: value for key, value in document.data.items() if key not in MACHINE_SECTIONS}
    if data.get("kind") == "chain" and isinstance(model := data.get("model"), str):
        data["model"] = str(document.path.parent / model)
    return _inside(data)


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
