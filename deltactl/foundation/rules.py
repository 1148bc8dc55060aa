"""What the keys of one section demand of each other, told beside its other mistakes.

A validator of a whole section does not run while one of its keys is wrong, and would keep what it
knows for the next round. A rule names the keys it needs, and runs where those are right.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from typing import Annotated, Any, Literal, Self, TypeVar, get_args, get_origin

from pydantic import BaseModel, ConfigDict, TypeAdapter, ValidationError, model_validator

from deltactl.foundation.schema_keys import models_in
from deltactl.foundation.yaml_tree import Location

Check = TypeVar("Check", bound=Callable[[Any], None])


class StrictModel(BaseModel):
    """Base of every configuration section: frozen, typed strictly, unknown keys refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


def rule(*keys: str) -> Callable[[Check], Check]:
    """Marks a method that raises ValueError where these keys of a section do not agree."""

    def marked(check: Check) -> Check:
        check.__dict__["of_keys"] = keys
        return check

    return marked


class RuledModel(StrictModel):
    """A section with rules."""

    @model_validator(mode="after")
    def _keeps_its_rules(self) -> Self:
        for check in _rules(type(self)):
            check(self)
        return self


@cache
def _rules(model: type[BaseModel]) -> tuple[Callable[[Any], None], ...]:
    found = {name: one for base in reversed(model.__mro__) for name, one in vars(base).items()}
    return tuple(one for one in found.values() if getattr(one, "of_keys", None))


def broken_rules(
    model: type[BaseModel], data: Mapping[str, Any], place: Location = ()
) -> Iterator[tuple[Location, str]]:
    """Where rules are broken, in the values of a file with whatever other mistakes."""
    if checks := _rules(model):
        right = valid_keys_of(model, data)
        if data.keys() - model.model_fields.keys():  # a misspelt key may be the one that is missing
            right = {key: value for key, value in right.items() if key in data}
        section = model.model_construct(**right)
        for check in checks:
            if all(key in right for key in getattr(check, "of_keys", ())):
                try:
                    check(section)
                except ValueError as error:
                    yield place, str(error)
    for name, field in model.model_fields.items():
        for below, inner in _sections_in(data.get(name), (*place, name)):
            if meant := _meant(models_in(field.annotation), inner):
                yield from broken_rules(meant, inner, below)


def valid_keys_of(model: type[BaseModel], data: Mapping[str, Any]) -> dict[str, Any]:
    """Values of the keys that are right, and the defaults of those that are not given."""
    found: dict[str, Any] = {}
    for name, field in model.model_fields.items():
        if name not in data:
            if not field.is_required():
                found[name] = field.get_default(call_default_factory=True)
            continue
        declared: Any = Annotated[field.annotation, field]
        section: TypeAdapter[Any] = TypeAdapter(declared)
        try:
            found[name] = section.validate_json(json.dumps(data[name]), strict=True)
        except ValidationError:
            continue  # said already
    return found


def _sections_in(value: Any, place: Location) -> Iterator[tuple[Location, Mapping[str, Any]]]:
    """A value that is a section, the sections of a list, and those that have names."""
    if isinstance(value, dict):
        yield place, value
    many = enumerate(value) if isinstance(value, list) else ()
    for part, inner in value.items() if isinstance(value, dict) else many:
        if isinstance(inner, dict):
            yield (*place, part), inner


def _meant(candidates: list[type[BaseModel]], data: Mapping[str, Any]) -> type[BaseModel] | None:
    """The model that a section is meant for: by its tag, else by the keys that it must have."""
    if len(candidates) == 1:
        return candidates[0]
    return next((one for one in candidates if _is_meant(one, data)), None)


def _is_meant(model: type[BaseModel], data: Mapping[str, Any]) -> bool:
    for name, field in model.model_fields.items():
        if get_origin(field.annotation) is Literal and len(get_args(field.annotation)) == 1:
            return bool(data.get(name, field.default) == get_args(field.annotation)[0])
    return all(name in data for name, one in model.model_fields.items() if one.is_required())
