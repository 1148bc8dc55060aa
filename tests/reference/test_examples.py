"""Every key has an example, and every example is one that the program takes."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Annotated, Any

import pytest
from pydantic import BaseModel, TypeAdapter

from deltactl.firmware_py.daemon.protocol import ARGUMENTS, parse
from deltactl.foundation.schema_keys import models_in
from deltactl.models.chain.active import activate
from deltactl.models.effects import TABLES, VOCABULARY
from deltactl.models.effects.kind import EffectKind
from deltactl.models.effects.lone_axis import command_effects, effort_effects, sensor_effects
from deltactl.models.robot import RangeSensor, ServoAxis, StepperAxis
from deltactl.reference.examples import EXAMPLES, READ, example_of, shipped_examples
from deltactl.reference.schemas import example
from deltactl.reference.words import ARGUMENT_WORDS


def models() -> list[type[BaseModel]]:
    found: list[type[BaseModel]] = []

    def walk(model: type[BaseModel]) -> None:
        if model not in found:
            found.append(model)
            for field in model.model_fields.values():
                for inner in models_in(field.annotation):
                    walk(inner)

    for whole in READ:
        walk(whole)
    return found


KEYS = [(model, name) for model in models() for name in model.model_fields]


@pytest.mark.parametrize(("model", "name"), KEYS, ids=lambda one: getattr(one, "__name__", one))
def test_a_key_takes_its_example(model: type[BaseModel], name: str) -> None:
    field = model.model_fields[name]
    value = example_of(model, field.alias or name)
    assert value is not None
    if field.alias is not None:
        model.model_validate_json(json.dumps({field.alias: value}), strict=True)
        return
    declared: Any = Annotated[field.annotation, field]
    TypeAdapter(declared).validate_json(json.dumps(value), strict=True)


def test_no_example_is_written_that_a_shipped_file_has() -> None:
    shipped = {f"{base.__name__}.{key}" for model, key in shipped_examples()
               for base in model.__mro__}  # fmt: skip
    assert not shipped & set(EXAMPLES)
    keys = {f"{base.__name__}.{model.model_fields[name].alias or name}" for model, name in KEYS
            for base in model.__mro__}  # fmt: skip
    assert set(EXAMPLES) <= keys


@pytest.mark.parametrize("model", [StepperAxis, ServoAxis, RangeSensor])
def test_a_name_is_that_of_such_a_machine(model: type[BaseModel]) -> None:
    assert example_of(model, "name") == example_of(model, "kind").replace("_", "-")


def effects() -> Iterator[EffectKind]:
    yield from VOCABULARY.values()
    yield from TABLES.values()
    for motion in ("linear", "rotary"):
        yield from command_effects(motion).values()
        yield from effort_effects(motion).values()
    yield from sensor_effects().values()


@pytest.mark.parametrize("kind", list(effects()), ids=lambda kind: kind.name)
def test_an_effect_takes_the_examples_of_its_parameters(kind: EffectKind) -> None:
    given = {one.name: example(kind, one) for one in kind.parameters}
    if kind.name in TABLES:  # where it begins must lie below where it ends
        given |= {"lowest": -0.2, "highest": 0.2}
    for component in kind.components:
        activate(kind, component, {k: tuple(v) if isinstance(v, list) else v
                                   for k, v in given.items()})  # fmt: skip


def test_the_socket_takes_the_examples() -> None:
    for do, arguments in ARGUMENTS.items():
        said = {name: ARGUMENT_WORDS[name].example for name in arguments}
        assert parse(json.dumps({"id": 1, "do": do, **said}).encode()).do == do
