"""JSON Schemas of the files and requests, those of `effects` from the cards of the effects."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from typing import Any

from pydantic import BaseModel

from deltactl.firmware_py.daemon.protocol import ARGUMENTS, Argument
from deltactl.firmware_py.job_file import JobFile
from deltactl.foundation.schema_keys import models_in
from deltactl.foundation.yaml_tree import WORDS
from deltactl.models.effects import CARDS, PORT_TEXT, TABLES, VOCABULARY
from deltactl.models.effects.kind import EffectKind, Parameter
from deltactl.models.effects.lone_axis import (
    Motion,
    command_effects,
    effort_effects,
    sensor_effects,
)
from deltactl.recording.foreign import mapping
from deltactl.recording.foreign.units import IN_SI
from deltactl.recording.tables.flat import OF_A_CHAIN, UNITS
from deltactl.reference.examples import WHOLE, example_of
from deltactl.reference.fields import key
from deltactl.reference.words import ARGUMENT_WORDS, REQUEST_WORDS

Schema = dict[str, Any]
OtherNames = Mapping[str, Mapping[str, str]]

BY_UNIT = {"s": 12.5, "rad": 0.1, "m": 0.1, "Hz": 6.0, "1": 1.0}
"""Examples of what has no typical size: when something happened, a period, a frequency."""


def entries() -> dict[str, Schema]:
    """The entry of each kind of machine, by the name of its definition, and what they share."""
    deltas = [*VOCABULARY.values(), *TABLES.values()]
    made = {
        "DeltaEffect": _entry(deltas),
        "StepperAxisEffect": _entry(command_effects("rotary").values()),
        "RotaryAxisEffect": _entry(_of_servo_axis("rotary")),
        "LinearAxisEffect": _entry(
            _of_servo_axis("linear"), {name: card.slide_names for name, card in CARDS.items()}
        ),
        "RangeSensorEffect": _entry(sensor_effects().values()),
    }
    return made | _shared(made)


def _shared(made: dict[str, Schema]) -> dict[str, Schema]:
    """Definitions of what several entries demand of an effect; the entries then refer to them."""
    places: dict[str, list[Schema]] = {}
    for entry in made.values():
        for demand in entry["allOf"]:
            places.setdefault(json.dumps(demand["if"]) + json.dumps(demand["then"]), []).append(
                demand
            )
    shared: dict[str, Schema] = {}
    for alike in places.values():
        if len(alike) > 1:
            effect = alike[0]["if"]["properties"]["effect"]["const"]
            name = f"{effect}_{sum(known.startswith(effect) for known in shared) + 1}"
            shared[name] = alike[0]["then"]
            for demand in alike:
                demand["then"] = {"$ref": f"#/$defs/{name}"}
    return shared


def _of_servo_axis(motion: Motion) -> list[EffectKind]:
    """Effects of an axis whose recordings may have commands, efforts, or both."""
    return [*command_effects(motion).values(), *effort_effects(motion).values()]


def _entry(kinds: Iterable[EffectKind], other_names: OtherNames | None = None) -> Schema:
    """One entry; what its effect demands is under `then`, so that a mistake is reported for it."""
    shapes: dict[str, list[Schema]] = {}
    for kind in kinds:
        shape = _shape(kind, (other_names or {}).get(kind.name, {}))
        shapes.setdefault(kind.name, []).append(shape)
    return {
        "type": "object",
        "properties": {"effect": {"enum": sorted(shapes)}},
        "required": ["effect", "component"],
        "allOf": [_if_effect(name, shapes[name]) for name in sorted(shapes)],
    }


def _if_effect(name: str, shapes: list[Schema]) -> Schema:
    return {
        "if": {"properties": {"effect": {"const": name}}, "required": ["effect"]},
        "then": shapes[0] if len(shapes) == 1 else {"anyOf": shapes},
    }


def _shape(kind: EffectKind, other_names: Mapping[str, str]) -> Schema:
    """Component and parameters of one effect, under either of their names."""
    needed = [parameter.name for parameter in kind.parameters if parameter.default is None]
    properties: Schema = {}
    for parameter in kind.parameters:
        properties[parameter.name] = _parameter(kind, parameter)
        if parameter.name in other_names:
            properties[other_names[parameter.name]] = _parameter(kind, parameter)
    parameters: Schema = {
        "type": "object",
        "properties": properties,
        "additionalProperties": False,
        "allOf": [_needs(name, other_names.get(name, name)) for name in needed],
    }
    return {
        "properties": {"component": {"enum": list(kind.components)}, "parameters": parameters},
        "required": ["parameters"] if needed else [],
    }


def _needs(name: str, other: str) -> Schema:
    if name == other:
        return {"required": [name]}
    return {"oneOf": [{"required": [name]}, {"required": [other]}]}


def _parameter(kind: EffectKind, parameter: Parameter) -> Schema:
    bounds = {"minimum": parameter.low, "maximum": parameter.high}
    number: Schema = {"type": "number"} | {k: v for k, v in bounds.items() if math.isfinite(v)}
    if parameter.size > 1:
        least = 2 if parameter.up_to else parameter.size
        number = {"type": "array", "items": number, "minItems": least, "maxItems": parameter.size}
    elif parameter.default is not None and math.isfinite(parameter.default):
        number["default"] = parameter.default
    unit = "a ratio" if parameter.unit == "1" else parameter.unit
    return number | {
        "description": f"{unit}; at: {PORT_TEXT[kind.port]}",
        "examples": [example(kind, parameter)],
    }


def example(kind: EffectKind, parameter: Parameter) -> float | list[float]:
    """A typical size; where an effect has none, its default, where a fit starts, or any."""
    value = _typical(kind, parameter)
    if parameter.up_to:
        return [0.0, value, 0.0]
    return [*[0.0] * (parameter.size - 1), value] if parameter.size > 1 else value


def _typical(kind: EffectKind, parameter: Parameter) -> float:
    if parameter.typical is not None:
        size = 1.0 / parameter.typical if parameter.reciprocal else parameter.typical
        nothing = kind.nothing if parameter is kind.main and math.isfinite(kind.nothing) else 0.0
        return float(f"{size + nothing:.4g}")
    guesses = (
        parameter.default,
        *parameter.starts,
        BY_UNIT.get(parameter.unit),
        parameter.low,
        parameter.high,
    )
    finite = (x for x in guesses if x is not None and math.isfinite(x))
    return next(x for x in finite if x != 0.0 and parameter.low <= x <= parameter.high)


DIALECT = "https://json-schema.org/draft/2020-12/schema"
TYPES = {int: "integer", float: "number"}

SWITCH: Schema = {
    "anyOf": [
        {"type": "boolean"},
        {"enum": [word for word, value in WORDS.items() if isinstance(value, bool)]},
    ]
}
"""`on` is true in these files, as in YAML 1.1; editors read YAML 1.2, where it is a text."""


def schemas() -> dict[str, str]:
    """Text of each schema by its name under schemas/."""
    made = {
        "job.json": ("A job of deltactl", _of_model(JobFile)),
        "robot.json": ("A robot file of deltactl", _robots()),
        "mapping.json": ("How a table of somebody else is read", _mapping()),
        "request.json": ("A request to the daemon", _request()),
    }
    return {
        name: json.dumps({"$schema": DIALECT, **schema, "title": title}, indent=1) + "\n"
        for name, (title, schema) in made.items()
    }


def _of_model(model: type[BaseModel]) -> Schema:
    """The schema of a file, with words, units and examples under every key."""
    schema = model.model_json_schema()
    definitions = schema.get("$defs", {})
    for inner in _below(model):
        _annotate(definitions.get(inner.__name__, schema), inner)
    switched: Schema = _with_switches(schema)
    return switched


def _below(model: type[BaseModel], seen: tuple[type[BaseModel], ...] = ()) -> list[type[BaseModel]]:
    """A model and all below it, each once."""
    found = [model]
    for field in model.model_fields.values():
        for inner in models_in(field.annotation):
            if inner not in (*seen, *found):
                found += _below(inner, (*seen, *found))
    return list(dict.fromkeys(found))


def _annotate(schema: Schema, model: type[BaseModel]) -> None:
    for name, field in model.model_fields.items():
        said = key(name, field, model)
        entry = schema["properties"][said.name]
        entry["description"] = f"{said.unit}; {said.says}" if said.unit else said.says
        entry["examples"] = [example_of(model, said.name)]


def _with_switches(schema: Any) -> Any:
    """Wherever something is on or off, the words for it too."""
    if isinstance(schema, list):
        return [_with_switches(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    inner = {name: _with_switches(value) for name, value in schema.items()}
    if schema.get("type") != "boolean":
        return inner
    return {name: value for name, value in inner.items() if name != "type"} | SWITCH


def _robots() -> Schema:
    """Every kind of machine, each with the effects that it may have."""
    definitions: Schema = entries()
    for name, model in WHOLE.items():
        if name != "job":
            whole = _of_model(model)
            definitions |= whole.pop("$defs", {})
            definitions[model.__name__] = whole
    kinds = {name: model.__name__ for name, model in WHOLE.items() if name != "job"}
    _take_effects(definitions["RobotFile"], "DeltaEffect")
    _take_effects(definitions["AsBuilt"], "DeltaEffect")
    _take_effects(definitions["StepperAxis"], "StepperAxisEffect")
    _take_effects(definitions["RangeSensor"], "RangeSensorEffect")
    definitions["ServoAxis"]["allOf"] = [
        _if("motion", motion, {"properties": {"effects": {"items": _to(entry)}}})
        for motion, entry in (("linear", "LinearAxisEffect"), ("rotary", "RotaryAxisEffect"))
    ]
    return {
        "$defs": definitions,
        "type": "object",
        "properties": {"kind": {"enum": list(kinds), "description": "The kind of machine."}},
        "required": ["kind"],
        "allOf": [_if("kind", kind, _to(name)) for kind, name in kinds.items()],
    }


def _take_effects(schema: Schema, entry: str) -> None:
    """Put what `effects` may hold beside what every entry has."""
    effects = schema["properties"]["effects"]
    for list_of in (effects, *effects.get("anyOf", ())):
        if list_of.get("type") == "array":
            list_of["items"] = {"allOf": [list_of["items"], _to(entry)]}


def _if(name: str, value: str, then: Schema) -> Schema:
    return {"if": {"properties": {name: {"const": value}}, "required": [name]}, "then": then}


def _to(name: str) -> Schema:
    return {"$ref": f"#/$defs/{name}"}


def _mapping() -> Schema:
    schema = _of_model(mapping.Mapping)
    schema["properties"]["columns"]["propertyNames"] = {
        "anyOf": [{"enum": list(UNITS)}, {"pattern": f"^({OF_A_CHAIN.pattern})$"}]
    }
    schema["$defs"]["Source"]["properties"]["unit"]["enum"] = list(IN_SI)
    return schema


def _request() -> Schema:
    return {
        "type": "object",
        "properties": {"do": {"enum": list(ARGUMENTS), "description": "What is asked for."}},
        "required": ["do"],
        "allOf": [_if("do", do, _of_request(do, arguments)) for do, arguments in ARGUMENTS.items()],
    }


def _of_request(do: str, arguments: dict[str, Argument]) -> Schema:
    return {
        "properties": {
            "id": {
                "type": ["integer", "string", "null"],
                "default": None,
                "examples": [1],
                "description": "Number of the request; its answer carries the same.",
            },
            "do": {"const": do, "description": REQUEST_WORDS[do], "examples": [do]},
            **{name: _argument(name, argument) for name, argument in arguments.items()},
        },
        "additionalProperties": False,
    }


def _argument(name: str, argument: Argument) -> Schema:
    words = ARGUMENT_WORDS[name]
    said = {"description": words.says, "examples": [words.example]}
    if words.default is not None:
        said["default"] = words.default
    if argument.type is str:
        return {
            "type": "string",
            "minLength": int(argument.least),
            "maxLength": int(argument.most),
        } | said
    if argument.type is bool:
        return {"type": "boolean"} | said
    return {
        "type": TYPES[argument.type],
        "minimum": argument.least,
        "maximum": argument.most,
    } | said
