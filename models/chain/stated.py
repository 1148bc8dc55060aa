"""Effects that a robot file states: all that is wrong with them, by where it stands."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from pydantic import ValidationError

from deltactl.foundation.errors import ConfigError
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
from deltactl.models.robot import EffectEntry, RobotModel

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
    kinds = [vocabulary(one) for one in MOTIONS if one == motion
             for vocabulary in (command_effects, effort_effects)]  # fmt: skip
    return _together(*(_by_file(one) if motion == "linear" else one for one in kinds))


def _together(*vocabularies: Mapping[str, EffectKind]) -> Forms:
    names = sorted({name for one in vocabularies for name in one})
    return {name: [one[name] for one in vocabularies if name in one] for name in names}


def _by_file(kinds: Mapping[str, EffectKind]) -> Mapping[str, EffectKind]:
    """With the names that a file has for the parameters of an axis that slides."""
    return {name: _renamed(kind, card_of(name).slide_names) for name, kind in kinds.items()}


def _renamed(kind: EffectKind, names: Mapping[str, str]) -> EffectKind:
    named = (replace(one, name=names.get(one.name, one.name)) for one in kind.parameters)
    return replace(kind, parameters=tuple(named))


def _wrong(entry: EffectEntry, forms: Forms) -> str:
    """What is wrong with an entry; empty where one of the forms of its effect takes it."""
    if not forms:
        return ""
    if entry.effect not in forms:
        return f"effect '{entry.effect}' must be one of {', '.join(sorted(forms))}"
    said = []
    for kind in forms[entry.effect]:
        known = {one.name for one in kind.parameters}
        names = {a: b for a, b in card_of(entry.effect).slide_names.items() if b in known}
        given = {names.get(name, name): value for name, value in entry.parameters.items()}
        try:
            activate(kind, entry.component, given)
        except ConfigError as error:
            said.append(str(error))
        else:
            return ""
    return said[0]
