"""Entries of `effects` as JSON Schemas, from the tables of the effects that there are."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from typing import Any

from deltactl.models.effects import CARDS, PORT_TEXT, TABLES, VOCABULARY
from deltactl.models.effects.kind import EffectKind, Parameter
from deltactl.models.effects.lone_axis import (
    Motion,
    command_effects,
    effort_effects,
    sensor_effects,
)

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
        for one in entry["allOf"]:
            places.setdefault(json.dumps(one["if"]) + json.dumps(one["then"]), []).append(one)
    shared: dict[str, Schema] = {}
    for alike in places.values():
        if len(alike) > 1:
            effect = alike[0]["if"]["properties"]["effect"]["const"]
            name = f"{effect}_{sum(one.startswith(effect) for one in shared) + 1}"
            shared[name] = alike[0]["then"]
            for one in alike:
                one["then"] = {"$ref": f"#/$defs/{name}"}
    return shared


def _of_servo_axis(motion: Motion) -> list[EffectKind]:
    """Of an axis whose recordings may have commands, efforts, or both."""
    return [*command_effects(motion).values(), *effort_effects(motion).values()]


def _entry(kinds: Iterable[EffectKind], other_names: OtherNames | None = None) -> Schema:
    """One entry; what its effect demands stands under `then`, so that a mistake is told of it."""
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
    needed = [one.name for one in kind.parameters if one.default is None]
    properties: Schema = {}
    for one in kind.parameters:
        properties[one.name] = _parameter(kind, one)
        if one.name in other_names:
            properties[other_names[one.name]] = _parameter(kind, one)
    parameters: Schema = {
        "type": "object", "properties": properties, "additionalProperties": False,
        "allOf": [_needs(name, other_names.get(name, name)) for name in needed],
    }  # fmt: skip
    return {
        "properties": {"component": {"enum": list(kind.components)}, "parameters": parameters},
        "required": ["parameters"] if needed else [],
    }


def _needs(name: str, other: str) -> Schema:
    if name == other:
        return {"required": [name]}
    return {"oneOf": [{"required": [name]}, {"required": [other]}]}


def _parameter(kind: EffectKind, one: Parameter) -> Schema:
    bounds = {"minimum": one.low, "maximum": one.high}
    number: Schema = {"type": "number"} | {k: v for k, v in bounds.items() if math.isfinite(v)}
    if one.size > 1:
        least = 2 if one.up_to else one.size
        number = {"type": "array", "items": number, "minItems": least, "maxItems": one.size}
    elif one.default is not None and math.isfinite(one.default):
        number["default"] = one.default
    unit = "a ratio" if one.unit == "1" else one.unit
    return number | {
        "description": f"{unit}; at: {PORT_TEXT[kind.port]}",
        "examples": [example(kind, one)],
    }


def example(kind: EffectKind, one: Parameter) -> float | list[float]:
    """A typical size; where an effect has none, its default, where a fit starts, or any."""
    value = _typical(kind, one)
    if one.up_to:
        return [0.0, value, 0.0]
    return [*[0.0] * (one.size - 1), value] if one.size > 1 else value


def _typical(kind: EffectKind, one: Parameter) -> float:
    if one.typical is not None:
        size = 1.0 / one.typical if one.reciprocal else one.typical
        nothing = kind.nothing if one is kind.main and math.isfinite(kind.nothing) else 0.0
        return float(f"{size + nothing:.4g}")
    guesses = (one.default, *one.starts, BY_UNIT.get(one.unit), one.low, one.high)
    finite = (x for x in guesses if x is not None and math.isfinite(x))
    return next(x for x in finite if x != 0.0 and one.low <= x <= one.high)
