"""YAML files read strictly: a mistake is one line with file, line, what is wrong, and a way out."""

from __future__ import annotations

import difflib
import json
import math
import re
from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydantic import BaseModel, ConfigDict, ValidationError

from foundation.errors import ConfigError, MissingFile

Location = tuple[str | int, ...]
ModelT = TypeVar("ModelT", bound=BaseModel)

# YAML 1.1 reads 5e-5 as a string because it has no dot; people write step periods that way.
_FLOAT = re.compile(
    r"^[-+]?(?:[0-9][0-9_]*\.[0-9_]*|\.[0-9_]+|[0-9][0-9_]*(?=[eE]))(?:[eE][-+]?[0-9]+)?$"
)


class StrictModel(BaseModel):
    """Base of every configuration section: frozen, typed strictly, unknown keys refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class _Loader(yaml.SafeLoader):
    """SafeLoader that also takes floats like 5e-5."""


_Loader.add_implicit_resolver("tag:yaml.org,2002:float", _FLOAT, list("-+0123456789."))


class Document:
    """A parsed YAML file that remembers on which line every key stands."""

    def __init__(self, path: Path, text: str):
        self.path = path
        self.text = text
        self.lines: dict[Location, int] = {}
        self.data = self._parse(text)

    @classmethod
    def read(cls, path: Path) -> Document:
        """Read a file. Raises MissingFile when unreadable, ConfigError when no YAML."""
        try:
            return cls(path, path.read_text(encoding="utf-8"))
        except UnicodeDecodeError as error:
            raise ConfigError(f"{path}: is not a text file (byte {error.start})") from error
        except OSError as error:
            reason = error.strerror or str(error)
            raise MissingFile(f"{path}: cannot be read ({reason}); check the path") from error

    def line_of(self, location: Location) -> int:
        """Line of the deepest part of `location` that stands in the file (1 if none does)."""
        for end in range(len(location), 0, -1):
            if location[:end] in self.lines:
                return self.lines[location[:end]]
        return 1

    def fail(self, location: Location, message: str) -> ConfigError:
        """A ConfigError that names file, line and key."""
        key = ".".join(str(part) for part in location)
        return ConfigError(
            f"{self.path}:{self.line_of(location)}: {key + ': ' if key else ''}{message}"
        )

    def check(self, model: type[ModelT], data: object | None = None) -> ModelT:
        """Turn the document (or `data`, a part of it) into `model`. Raises ConfigError."""
        payload = json.dumps(self.data if data is None else data)
        try:
            return model.model_validate_json(payload)
        except ValidationError as error:
            raise self._explain(model, error) from None

    def _parse(self, text: str) -> dict[str, Any]:
        try:
            node = yaml.compose(text, Loader=_Loader)
        except yaml.MarkedYAMLError as error:
            line = error.problem_mark.line + 1 if error.problem_mark else 1
            raise ConfigError(f"{self.path}:{line}: is not YAML: {error.problem}") from error
        except (yaml.YAMLError, ValueError, RecursionError) as error:
            summary = str(error).splitlines()[0]
            raise ConfigError(f"{self.path}:1: is not YAML: {summary}") from error
        if not isinstance(node, yaml.MappingNode):
            raise ConfigError(f"{self.path}:1: must be a list of 'key: value' lines")
        value = self._value(node, ())
        assert isinstance(value, dict)
        return value

    def _value(self, node: yaml.Node, location: Location) -> Any:
        if len(location) > 20:
            raise ConfigError(f"{self.path}:{node.start_mark.line + 1}: nested too deeply")
        if isinstance(node, yaml.MappingNode):
            return self._mapping(node, location)
        if isinstance(node, yaml.SequenceNode):
            items = []
            for index, child in enumerate(node.value):
                self.lines[(*location, index)] = child.start_mark.line + 1
                items.append(self._value(child, (*location, index)))
            return items
        return self._scalar(node, location)

    def _mapping(self, node: yaml.MappingNode, location: Location) -> dict[str, Any]:
        result: dict[str, Any] = {}
        for key_node, child in node.value:
            line = key_node.start_mark.line + 1
            key = key_node.value
            if not isinstance(key, str):
                raise ConfigError(f"{self.path}:{line}: a key must be a plain word")
            if key in result:
                raise ConfigError(f"{self.path}:{line}: '{key}' stands here twice; remove one")
            self.lines[(*location, key)] = line
            result[key] = self._value(child, (*location, key))
        return result

    def _scalar(self, node: yaml.Node, location: Location) -> Any:
        try:
            value = _Loader("").construct_object(node)
        except (yaml.YAMLError, ValueError) as error:
            raise self.fail(location, f"cannot be read: {str(error).splitlines()[0]}") from error
        if isinstance(value, float) and not math.isfinite(value):
            raise self.fail(location, f"must be a finite number, not {value}")
        if value is not None and not isinstance(value, str | int | float | bool):
            return str(node.value)
        return value

    def _explain(self, model: type[BaseModel], error: ValidationError) -> ConfigError:
        # A misspelt key is also a missing one: the misspelling is what the user can see.
        found = sorted(
            error.errors(include_url=False), key=lambda one: one["type"] != "extra_forbidden"
        )
        first = found[0]
        location = self._in_file(first["loc"])
        if first["type"] == "extra_forbidden":
            key = str(location[-1])
            return self.fail(
                location, f"unknown key{_nearest(key, _valid_keys(model, first['loc'][:-1]))}"
            )
        if first["type"] == "missing":
            missing = first["loc"][-1]
            return self.fail(
                location[:-1] if location[-1:] == (missing,) else location,
                f"'{missing}' is missing",
            )
        message = first["msg"].removeprefix("Value error, ")
        return self.fail(location, f"{message}{_got(first)}")

    def _in_file(self, loc: Location) -> Location:
        """Drop the parts of a pydantic location that are union tags, not keys of the file."""
        kept: Location = ()
        for index, part in enumerate(loc):
            if (*kept, part) in self.lines or index == len(loc) - 1:
                kept = (*kept, part)
        return kept


def _got(first: Any) -> str:
    value = first["input"]
    if isinstance(value, dict | list) or first["type"] == "value_error":
        return ""
    return f" (got {value!r})"


def _nearest(key: str, valid: list[str]) -> str:
    close = difflib.get_close_matches(key, valid, n=1, cutoff=0.5)
    if close:
        return f"; did you mean '{close[0]}'?"
    return f"; valid keys: {', '.join(valid)}" if valid else ""


def _valid_keys(model: type[BaseModel], loc: Location) -> list[str]:
    """Field names valid at `loc`, following nested models and tagged unions."""
    candidates: list[Any] = [model]
    for part in loc:
        candidates = [inner for candidate in candidates for inner in _step_into(candidate, part)]
    return sorted({name for found in candidates for name in getattr(found, "model_fields", {})})


def _step_into(candidate: Any, part: str | int) -> list[Any]:
    fields = getattr(candidate, "model_fields", {})
    if part in fields:
        return _models_in(fields[part].annotation)
    return [candidate] if _carries_tag(candidate, part) or isinstance(part, int) else []


def _carries_tag(candidate: Any, part: str | int) -> bool:
    """Whether `part` is the discriminator value (or class name) of this union member."""
    if part == getattr(candidate, "__name__", None):
        return True
    for field in getattr(candidate, "model_fields", {}).values():
        if part in getattr(field.annotation, "__args__", ()):
            return True
    return False


def _models_in(annotation: Any) -> list[Any]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [found for inner in getattr(annotation, "__args__", ()) for found in _models_in(inner)]


def load(path: Path, model: type[ModelT]) -> ModelT:
    """Read `path` and check it against `model`. Raises MissingFile or ConfigError (one line)."""
    return Document.read(path).check(model)
