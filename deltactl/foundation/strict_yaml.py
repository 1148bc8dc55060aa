"""YAML files read strictly: a mistake is one line with file, line, what is wrong, and a way out."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from deltactl.foundation.errors import ConfigError
from deltactl.foundation.explain import explain_all
from deltactl.foundation.plain_file import TooLong, read_plain
from deltactl.foundation.rules import StrictModel, broken_rules
from deltactl.foundation.yaml_tree import Location, Tree, YamlError

__all__ = ["Document", "StrictModel", "load"]

ModelT = TypeVar("ModelT", bound=BaseModel)

MOST_MISTAKES = 20
MAX_BYTES = 20_000_000
"""Several times the largest job (100,000 joint poses); a wrong file must not fill the memory."""


class Document:
    """A parsed YAML file that remembers on which line every key stands."""

    def __init__(self, path: Path, text: str):
        self.path = path
        self.text = text
        self.lines: dict[Location, int] = {}
        self.data = self._parse(text)

    @classmethod
    def read(cls, path: Path, follow: bool = True, most_bytes: int = MAX_BYTES) -> Document:
        """Read a file. Raises MissingFile when unreadable, ConfigError when no YAML.

        follow: whether links may lead to it.
        """
        try:
            text = read_plain(path, most_bytes, follow).decode("utf-8-sig")
        except UnicodeDecodeError as error:
            told = "; recordings are for 'deltactl report' and 'diagnose'"
            hint = told if path.suffix == ".mcap" else ""
            raise ConfigError(f"{path}: is not a text file in UTF-8{hint}") from error
        except TooLong:
            raise ConfigError(f"{path}: is longer than {most_bytes:,} bytes") from None
        return cls(path, text.replace("\r\n", "\n"))

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

    def fail_all(self, mistakes: Iterable[tuple[Location, str]]) -> ConfigError:
        """One ConfigError for several mistakes; at most MOST_MISTAKES of them are listed."""
        lines = [str(self.fail(*mistake)) for mistake in mistakes]
        more = len(lines) - MOST_MISTAKES
        if more > 0:
            lines[MOST_MISTAKES:] = [f"{self.path}: and {more} more mistakes"]
        return ConfigError(*lines)

    def check(self, model: type[ModelT], data: object | None = None) -> ModelT:
        """Turn the document (or `data`, a part of it) into `model`. Raises ConfigError."""
        values = self.data if data is None else data
        try:
            return model.model_validate_json(json.dumps(values))
        except ValidationError as error:
            found = explain_all(model, error, self.lines)
            if isinstance(values, dict):
                found = list(dict.fromkeys([*found, *broken_rules(model, values)]))
            found.sort(key=lambda mistake: self.line_of(mistake[0]))
            raise self.fail_all(found) from None

    def _parse(self, text: str) -> dict[str, Any]:
        try:
            tree = Tree(text)
        except YamlError as error:
            raise ConfigError(f"{self.path}:{error.line}: {error}") from error
        if not isinstance(tree.value, dict):
            raise ConfigError(f"{self.path}:1: must be a list of 'key: value' lines")
        self.lines = tree.lines
        self._refuse_infinite(tree.value, ())
        return tree.value

    def _refuse_infinite(self, value: Any, location: Location) -> None:
        if isinstance(value, float) and not math.isfinite(value):
            raise self.fail(location, f"must be a finite number, not {value}")
        inner = enumerate(value) if isinstance(value, list) else ()
        for key, child in value.items() if isinstance(value, dict) else inner:
            self._refuse_infinite(child, (*location, key))


def load(path: Path, model: type[ModelT]) -> ModelT:
    """Read `path` and check it against `model`. Raises MissingFile or ConfigError (one line)."""
    return Document.read(path).check(model)
