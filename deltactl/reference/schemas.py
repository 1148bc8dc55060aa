"""JSON Schemas for editors and for other programs."""

from __future__ import annotations

import json
from typing import Any

from pydantic import BaseModel

from deltactl.firmware_py.daemon.protocol import ARGUMENTS, Argument
from deltactl.firmware_py.job_file import JobFile
from deltactl.foundation.schema_keys import models_in
from deltactl.foundation.yaml_tree import WORDS
from deltactl.recording.foreign.mapping import Mapping
from deltactl.recording.foreign.units import IN_SI
from deltactl.recording.tables.flat import UNITS
from deltactl.reference import effect_schemas
from deltactl.reference.examples import WHOLE, example_of
from deltactl.reference.fields import key
from deltactl.reference.socket_words import ARGUMENT_WORDS, REQUEST_WORDS

DIALECT = "https://json-schema.org/draft/2020-12/schema"
TYPES = {int: "integer", float: "number"}
Schema = dict[str, Any]

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
    for one in _below(model):
        _annotate(definitions.get(one.__name__, schema), one)
    switched: Schema = _with_switches(schema)
    return switched


def _below(model: type[BaseModel], seen: tuple[type[BaseModel], ...] = ()) -> list[type[BaseModel]]:
    """A model and all that stand below it, each once."""
    found = [model]
    for field in model.model_fields.values():
        for inner in models_in(field.annotation):
            if inner not in (*seen, *found):
                found += _below(inner, (*seen, *found))
    return list(dict.fromkeys(found))


def _annotate(schema: Schema, model: type[BaseModel]) -> None:
    for name, field in model.model_fields.items():
        said = key(name, field, model)
        one = schema["properties"][said.name]
        one["description"] = f"{said.unit}; {said.says}" if said.unit else said.says
        one["examples"] = [example_of(model, said.name)]


def _with_switches(schema: Any) -> Any:
    """Wherever something is on or off, the words for it too."""
    if isinstance(schema, list):
        return [_with_switches(one) for one in schema]
    if not isinstance(schema, dict):
        return schema
    inner = {name: _with_switches(value) for name, value in schema.items()}
    if schema.get("type") != "boolean":
        return inner
    return {name: value for name, value in inner.items() if name != "type"} | SWITCH


def _robots() -> Schema:
    """Every kind of machine, each with the effects that it may have."""
    definitions: Schema = effect_schemas.entries()
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
    """Put what may stand in `effects` beside what every entry has."""
    effects = schema["properties"]["effects"]
    for one in (effects, *effects.get("anyOf", ())):
        if one.get("type") == "array":
            one["items"] = {"allOf": [one["items"], _to(entry)]}


def _if(name: str, value: str, then: Schema) -> Schema:
    return {"if": {"properties": {name: {"const": value}}, "required": [name]}, "then": then}


def _to(name: str) -> Schema:
    return {"$ref": f"#/$defs/{name}"}


def _mapping() -> Schema:
    schema = _of_model(Mapping)
    schema["properties"]["columns"]["propertyNames"] = {"enum": list(UNITS)}
    schema["$defs"]["Source"]["properties"]["unit"]["enum"] = list(IN_SI)
    return schema


def _request() -> Schema:
    return {
        "type": "object",
        "properties": {"do": {"enum": list(ARGUMENTS), "description": "What is asked for."}},
        "required": ["do"],
        "allOf": [_if("do", do, _of_request(do, one)) for do, one in ARGUMENTS.items()],
    }


def _of_request(do: str, arguments: dict[str, Argument]) -> Schema:
    return {
        "properties": {
            "id": {
                "type": ["integer", "string", "null"], "default": None, "examples": [1],
                "description": "Of the request; its answer carries the same.",
            },
            "do": {"const": do, "description": REQUEST_WORDS[do], "examples": [do]},
            **{name: _argument(name, one) for name, one in arguments.items()},
        },
        "additionalProperties": False,
    }  # fmt: skip


def _argument(name: str, one: Argument) -> Schema:
    words = ARGUMENT_WORDS[name]
    said = {"description": words.says, "examples": [words.example]}
    if words.default is not None:
        said["default"] = words.default
    if one.type is str:
        return {"type": "string", "minLength": int(one.least), "maxLength": int(one.most)} | said
    if one.type is bool:
        return {"type": "boolean"} | said
    return {"type": TYPES[one.type], "minimum": one.least, "maximum": one.most} | said
