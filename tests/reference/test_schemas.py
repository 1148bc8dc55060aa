"""What an editor says of a file is what the program says of it."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator
from functools import cache
from typing import Any

import jsonschema
import pytest
from ruamel.yaml import YAML

from deltactl.foundation.yaml_tree import Tree
from deltactl.reference.schemas import schemas
from tests.rigs.documented import ROOT

FILES = sorted((ROOT / "config").glob("*.yaml"))
ZHAO = (ROOT / "config" / "zhao-2023.yaml").read_text(encoding="utf-8")
SERVO = (ROOT / "config" / "servo-axis.yaml").read_text(encoding="utf-8")
SENSOR = (ROOT / "config" / "range-sensor.yaml").read_text(encoding="utf-8")
SCHEMAS = {name: json.loads(text) for name, text in schemas().items()}


def as_an_editor(text: str) -> Any:
    """By YAML 1.2, which the YAML language server reads: `on` and `off` are texts."""
    return YAML(typ="safe", pure=True).load(io.StringIO(text))


def as_the_program(text: str) -> Any:
    return Tree(text).value


@cache
def validator(schema: str) -> jsonschema.Draft202012Validator:
    """Of a schema that is one itself."""
    jsonschema.Draft202012Validator.check_schema(SCHEMAS[schema])
    return jsonschema.Draft202012Validator(SCHEMAS[schema])


def mistakes(text: str, schema: str = "robot.json") -> list[str]:
    return [one.message for one in validator(schema).iter_errors(as_an_editor(text))]


@pytest.mark.parametrize("read", [as_an_editor, as_the_program])
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_shipped_files_fit_their_schema(path: Any, read: Any) -> None:
    data = read(path.read_text(encoding="utf-8"))
    validator("robot.json" if "kind" in data else "job.json").validate(data)


@pytest.mark.parametrize("word", ["on", "off", "yes", "no", "true", "false", "On", "Off"])
def test_words_for_on_and_off(word: str) -> None:
    text = f"{ZHAO}\noutputs: {{gripper: {{pin: 12, safe: {word}}}}}\n"
    assert not mistakes(text)
    assert isinstance(as_the_program(text)["outputs"]["gripper"]["safe"], bool)
    assert mistakes(text.replace(f"safe: {word}", "safe: onn"))


def test_a_misspelt_key_does_not_fit() -> None:
    text = (ROOT / "config" / "heart.yaml").read_text(encoding="utf-8")
    assert not mistakes(text, "job.json")
    assert mistakes(text.replace("width_m", "widht_m"), "job.json")


def properties(schema: Any, place: str = "") -> Iterator[tuple[str, dict[str, Any]]]:
    """Every property that says what a value is, wherever it stands in a schema."""
    for name, inner in schema.items() if isinstance(schema, dict) else enumerate(schema):
        if name in ("if", "examples", "default", "enum"):
            continue
        if name == "properties":
            for key, one in inner.items():
                if not set(one) <= {"properties", "enum", "items", "type", "allOf", "required",
                                    "additionalProperties"} or "type" in one:  # fmt: skip
                    yield f"{place}.{key}", one
        if isinstance(inner, dict | list):
            yield from properties(inner, f"{place}.{name}")


@pytest.mark.parametrize("name", ["job.json", "robot.json", "mapping.json", "request.json"])
def test_every_property_is_described_and_has_an_example(name: str) -> None:
    said = [
        (place, one)
        for place, one in properties(SCHEMAS[name])
        if not place.endswith((".kind", ".do", ".parameters")) or "title" in one
    ]
    assert len(said) > 10
    assert [place for place, one in said if not one.get("description")] == []
    assert [place for place, one in said if not one.get("examples")] == []


def effect(text: str, entry: str) -> str:
    return f"{text}\neffects: [{entry}]\n"


RIGHT = [
    (ZHAO, "{effect: gear_backlash, component: motor2, parameters: {width: 0.004}}"),
    (ZHAO, "{effect: frame_tilt, component: frame, parameters: {rotation: [0, 0.01, 0]}}"),
    (ZHAO, "{effect: joint_table, component: motor1, parameters:"
     " {error: [0, 0.01], lowest: 0, highest: 1, follows: 1}}"),
    (SERVO, "{effect: home_offset, component: axis, parameters: {offset: 0.001}}"),
    (SERVO, "{effect: home_offset, component: axis, parameters: {angle: 0.001}}"),
    (SERVO, "{effect: joint_friction, component: axis, parameters: {width: 0.001}}"),
    (SERVO, "{effect: joint_friction, component: axis, parameters: {force: 3}}"),
    (SENSOR, "{effect: sensor_offset, component: axis, parameters: {offset: 0.001}}"),
]  # fmt: skip
WRONG = [
    (ZHAO, "{effect: gear_backlsh, component: motor2, parameters: {width: 0.004}}"),
    (ZHAO, "{effect: gear_backlash, component: axis, parameters: {width: 0.004}}"),
    (ZHAO, "{effect: gear_backlash, component: motor2, parameters: {widht: 0.004}}"),
    (ZHAO, "{effect: gear_backlash, component: motor2, parameters: {width: 4}}"),
    (ZHAO, "{effect: gear_backlash, component: motor2, parameters: {}}"),
    (ZHAO, "{effect: gear_backlash, component: motor2}"),
    (ZHAO, "{effect: frame_tilt, component: frame, parameters: {rotation: [0, 0.01]}}"),
    (SERVO, "{effect: home_offset, component: axis, parameters: {}}"),
    (SERVO, "{effect: joint_friction, component: axis, parameters: {torque: 3, force: 3}}"),
    (SERVO.replace("linear", "rotary").replace("{force_n: 0.0}", "{torque_nm: 0.0}"),
     "{effect: home_offset, component: axis, parameters: {offset: 0.001}}"),
    (SENSOR, "{effect: gear_backlash, component: axis, parameters: {width: 0.004}}"),
]  # fmt: skip


@pytest.mark.parametrize(("robot", "entry"), RIGHT)
def test_entries_of_effects_that_the_program_takes(robot: str, entry: str) -> None:
    assert not mistakes(effect(robot, entry))


@pytest.mark.parametrize(("robot", "entry"), WRONG)
def test_entries_of_effects_that_it_refuses(robot: str, entry: str) -> None:
    assert mistakes(effect(robot, entry))


def test_a_misspelt_effect_is_told_by_the_names_there_are() -> None:
    (said,) = mistakes(effect(*WRONG[0]))
    assert "'gear_backlsh' is not one of [" in said
    assert "'gear_backlash'" in said


def test_effects_as_built_are_those_of_a_delta() -> None:
    right = "{effect: gear_backlash, component: motor2, parameters: {width: 0.004}}"
    text = ZHAO + f"\nas_built: {{effects: [{right}]}}\n"
    assert not mistakes(text)
    assert mistakes(text.replace("motor2", "motor4"))
