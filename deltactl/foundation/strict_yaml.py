"""Checks between the keys of one section, reported together with its other mistakes.

A validator of a whole section does not run while one of its keys is wrong, and would keep what it
knows for the next round. A rule names the keys it needs, and runs where those are right.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache
from itertools import islice
from pathlib import Path
from typing import Annotated, Any, Literal, Self, TypeVar, get_args, get_origin

from pydantic import BaseModel, ConfigDict, TypeAdapter, ValidationError, model_validator

from deltactl.foundation.errors import ConfigError
from deltactl.foundation.explain import Mistake, mistakes_in
from deltactl.foundation.plain_file import TooLong, read_plain
from deltactl.foundation.schema_keys import first_parts, models_in
from deltactl.foundation.yaml_tree import MAX_VALUES, Location, Tree, YamlError, key_of

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
    found = {
        name: member for base in reversed(model.__mro__) for name, member in vars(base).items()
    }
    return tuple(member for member in found.values() if getattr(member, "of_keys", None))


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
    for name, candidates in _section_keys(model):
        for below, inner in _sections_in(data.get(name), (*place, name)):
            if meant := _meant(candidates, inner):
                yield from broken_rules(meant, inner, below)


@cache
def _section_keys(model: type[BaseModel]) -> tuple[tuple[str, list[type[BaseModel]]], ...]:
    """The keys whose values may be sections, and the models of these."""
    found = ((name, models_in(field.annotation)) for name, field in model.model_fields.items())
    return tuple((name, candidates) for name, candidates in found if candidates)


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
    return next((candidate for candidate in candidates if _is_meant(candidate, data)), None)


def _is_meant(model: type[BaseModel], data: Mapping[str, Any]) -> bool:
    if tag := _tag(model):
        name, default, value = tag
        return bool(data.get(name, default) == value)
    return all(name in data for name, field in model.model_fields.items() if field.is_required())


@cache
def _tag(model: type[BaseModel]) -> tuple[str, Any, Any] | None:
    """The key whose one value names the model, its default, and that value."""
    for name, field in model.model_fields.items():
        if get_origin(field.annotation) is Literal and len(get_args(field.annotation)) == 1:
            return name, field.default, get_args(field.annotation)[0]
    return None


__all__ = ["Document", "StrictModel", "load", "text_of"]

ModelT = TypeVar("ModelT", bound=BaseModel)

BYTES_A_VALUE = 8
"""A file may have so many values for its bound in bytes: more is no job, and takes long to read."""
MOST_MISTAKES = 20
"""So many are listed, and names near theirs searched for."""
MOST_COUNTED = 100
LONG = 20_000
"""Values of a file from which on it is read in parts first."""
FIRST_PARTS = (50, 2000)
"""Entries of each list and section that are tried before the whole."""
OF_WHOLE = ("value_error", "assertion_error")
MAX_BYTES = 20_000_000
"""Several times the largest job (100,000 joint poses); a wrong file must not fill the memory."""


class Document:
    """A parsed YAML file that remembers the line of every key."""

    def __init__(self, path: Path, text: str, most_values: int = MAX_VALUES):
        self.path = path
        self.text = text
        self._tree = self._parse(text, most_values)
        self.data: dict[str, Any] = self._tree.value

    @classmethod
    def read(cls, path: Path, follow: bool = True, most_bytes: int = MAX_BYTES) -> Document:
        """Read a file. Raises MissingFile when unreadable, ConfigError when no YAML.

        follow: whether links may lead to it.
        """
        text = text_of(path, follow, most_bytes)
        return cls(path, text, min(MAX_VALUES, most_bytes // BYTES_A_VALUE))

    def line_of(self, location: Location) -> int:
        """Line of the deepest part of `location` that is in the file (1 if none is)."""
        return self._tree.line_of(location)

    def fail(self, location: Location, message: str) -> ConfigError:
        """A ConfigError that names file, line and key."""
        key = key_of(location)
        return ConfigError(
            f"{self.path}:{self.line_of(location)}: {key + ': ' if key else ''}{message}"
        )

    def fail_all(self, mistakes: Iterable[Mistake]) -> ConfigError:
        """One ConfigError for several mistakes; at most MOST_MISTAKES of them are listed.

        No more than MOST_COUNTED are asked for.
        """
        found = list(islice(mistakes, MOST_COUNTED))
        return self._listed(found[:MOST_MISTAKES], len(found))

    @property
    def is_long(self) -> bool:
        """Whether looking through everything again would hold somebody up."""
        return self._tree.values > LONG

    def check(self, model: type[ModelT], data: object | None = None) -> ModelT:
        """Turn the document (or `data`, a part of it) into `model`. Raises ConfigError.

        The first parts of the lists and sections of a long file are tried first: a mistake that is
        made in every row is found there, and not a million times.
        """
        values = self.data if data is None else data
        for most in FIRST_PARTS if self.is_long else ():
            try:
                model.model_validate_json(json.dumps(first_parts(values, most, model)))
            except ValidationError as error:
                # What a section says as a whole may follow from what was left out.
                errors = [problem for problem in error.errors() if problem["type"] not in OF_WHOLE]
                if errors:
                    raise self._refused(model, errors, in_part=True) from None
        try:
            return model.model_validate_json(json.dumps(values))
        except ValidationError as error:
            rules: Iterable[Mistake] = ()
            if isinstance(values, dict) and not self.is_long:
                rules = broken_rules(model, values)
            raise self._refused(model, error.errors(include_url=False), rules) from None

    def _refused(
        self,
        model: type[BaseModel],
        errors: Sequence[Any],
        rules: Iterable[Mistake] = (),
        in_part: bool = False,
    ) -> ConfigError:
        """in_part: the errors are those of the first parts of the file."""
        found = mistakes_in(errors, self._tree, MOST_COUNTED)
        found.sort(key=lambda mistake: self.line_of(mistake.place))
        said = [mistake.says(model, self._tree) for mistake in found[:MOST_MISTAKES]]
        listed = list(dict.fromkeys([*said, *islice(rules, MOST_COUNTED)]))
        listed.sort(key=lambda mistake: self.line_of(mistake[0]))
        of = len(found) - len(said) + len(listed)
        return self._listed(listed[:MOST_MISTAKES], of, in_part)

    def _listed(self, mistakes: Sequence[Mistake], of: int, in_part: bool = False) -> ConfigError:
        lines = [str(self.fail(*mistake)) for mistake in mistakes]
        if (more := of - len(lines)) > 0:
            many = f"at least {more}" if in_part or of >= MOST_COUNTED else str(more)
            lines.append(f"{self.path}: and {many} more mistakes")
        return ConfigError(*lines)

    def _parse(self, text: str, most_values: int) -> Tree:
        try:
            tree = Tree(text, most_values)
        except YamlError as error:
            raise ConfigError(f"{self.path}:{error.line}: {error}") from error
        if not isinstance(tree.value, dict):
            raise ConfigError(f"{self.path}:1: must be a list of 'key: value' lines")
        return tree


def text_of(path: Path, follow: bool = True, most_bytes: int = MAX_BYTES) -> str:
    """The text of a file. Raises MissingFile when unreadable, ConfigError when no text."""
    try:
        text = read_plain(path, most_bytes, follow).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        told = "; recordings are for 'deltactl report' and 'diagnose'"
        hint = told if path.suffix == ".mcap" else ""
        raise ConfigError(f"{path}: is not a text file in UTF-8{hint}") from error
    except TooLong:
        raise ConfigError(f"{path}: is longer than {most_bytes:,} bytes") from None
    return text.replace("\r\n", "\n")


def load(path: Path, model: type[ModelT]) -> ModelT:
    """Read `path` and check it against `model`. Raises MissingFile or ConfigError (one line)."""
    return Document.read(path).check(model)
