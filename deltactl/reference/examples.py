"""An example of every key: from the shipped files where one has it, else from `examples.yaml`.

A value of a shipped file is an example of the model that reads it there, so that `name` of an axis
is the name of an axis. What no shipped file says is in
`examples.yaml`; a test holds each of those to its key.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import yaml
from pydantic import BaseModel, ValidationError

from deltactl.firmware_py.job_file import JobFile
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.schema_keys import models_in
from deltactl.foundation.yaml_tree import Tree
from deltactl.models.robot import KINDS
from deltactl.recording.foreign.mapping import Mapping

ROOT = Path(__file__).parents[2]
EXAMPLES: dict[str, Any] = yaml.safe_load(
    Path(__file__).with_name("examples.yaml").read_text("utf-8")
)
WHOLE: dict[str, type[BaseModel]] = {**KINDS, "delta": RobotFile, "job": JobFile}
"""What reads a whole file, by its `kind`; a job has none."""
READ = (*WHOLE.values(), Mapping)
"""Everything that a file of the reader's may be."""


def example_of(model: type[BaseModel], key: str) -> Any:
    """A value that this key may have. Raises KeyError where there is none."""
    shipped = shipped_examples()
    if (model, key) in shipped:
        return shipped[model, key]
    places = (f"{base.__name__}.{key}" for base in model.__mro__)
    return EXAMPLES[next((place for place in places if place in EXAMPLES), f"{model}.{key}")]


@cache
def shipped_examples() -> dict[tuple[type[BaseModel], str], Any]:
    """The first value in `config/` of each key, by the model that reads it."""
    found: dict[tuple[type[BaseModel], str], Any] = {}
    for path in sorted((ROOT / "config").glob("*.yaml")):
        data = Tree(path.read_text(encoding="utf-8")).value
        for place, value in _said(WHOLE[data.get("kind", "job")], data):
            found.setdefault(place, value)
    return found


def _said(
    model: type[BaseModel], data: dict[str, Any]
) -> Iterator[tuple[tuple[type[BaseModel], str], Any]]:
    for name, field in model.model_fields.items():
        value = data.get(field.alias or name)
        if value is None:
            continue
        yield (model, field.alias or name), value
        for inner in _dicts(value):
            if read_by := _reader(models_in(field.annotation), inner):
                yield from _said(read_by, inner)


def _dicts(value: Any) -> Iterator[dict[str, Any]]:
    """The sections in a value: itself, those of a list, those by name."""
    many = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    yield from (inner for inner in (value, *many) if isinstance(inner, dict))


def _reader(candidates: list[type[BaseModel]], data: dict[str, Any]) -> type[BaseModel] | None:
    """The model that takes this section."""
    for model in candidates:
        try:
            model.model_validate(data, strict=False)
        except ValidationError:
            continue
        return model
    return None
