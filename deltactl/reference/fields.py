"""What a configuration model says of its keys: type, unit, bounds, default, and in words."""

from __future__ import annotations

import ast
import inspect
import textwrap
import types
import typing
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from deltactl.foundation.schema_keys import models_in
from deltactl.reference.words import BOUNDED_ELSEWHERE, unit_of

NAMES = {int: "whole number", float: "number", str: "text", bool: "true or false"}
SIGNS = {"gt": "above", "ge": "from", "lt": "below", "le": "to"}
ANY = "any"
"""Said of a number that nothing bounds."""
LENGTHS = {"min_length": "at least", "max_length": "at most"}


@dataclass(frozen=True, slots=True)
class Key:
    """One key of a section."""

    name: str
    type: str
    unit: str
    bounds: str
    default: str
    says: str
    own: bool = True
    """Whether the key says this itself, not the section below it."""
    meaning: str = ""
    """What the key is, without the reason of its bounds where it says more than that."""


@dataclass(frozen=True, slots=True)
class Section:
    """One model: its place in the file, what it is, and its keys."""

    place: str
    choice: str
    """What selects it among others at the same place, as `shape: circle`."""
    says: str
    keys: tuple[Key, ...]
    model: type[BaseModel]

    def is_chosen_by(self, key: Key) -> bool:
        """Whether a key is the one that selects it."""
        return self.choice == f"{key.name}: {key.type.strip('`')}"


def sections(
    model: type[BaseModel], place: str = "", seen: set[type[BaseModel]] | None = None
) -> Iterator[Section]:
    """The section of a model and those below it, depth first.

    Below a list of steps, which may hold steps, each model is shown once.
    """
    seen = set() if seen is None else seen
    seen.add(model)
    keys = tuple(key(name, field, model) for name, field in model.model_fields.items())
    yield Section(place, _choice(model), inspect.getdoc(model) or "", keys, model)
    for name, field in model.model_fields.items():
        below = f"{place}.{name}" if place else name
        many = "[]" if _is_list(field.annotation) else ""
        for inner in models_in(field.annotation):
            if inner not in seen or "steps[]" not in below + many:
                yield from sections(inner, below + many, seen)


def key(name: str, field: FieldInfo, model: type[BaseModel]) -> Key:
    """What a field says."""
    known, kind = field.alias or name, _type(field.annotation)
    bounds, reason = _bounds(field)
    if not bounds and "number" in kind:
        bounds = BOUNDED_ELSEWHERE.get(known, ANY)
    own = _docstrings(model).get(name, "")
    borrowed = "" if own or reason else _of_its_section(name, field, model)
    default = "required" if field.is_required() else _shown(field)
    said = "; ".join(word.strip().rstrip(".") for word in (own, reason, borrowed) if word)
    return Key(known, kind, unit_of(known), bounds, default, said, not borrowed, own or said)


def _of_its_section(name: str, field: FieldInfo, model: type[BaseModel]) -> str:
    """Meaning of a key, taken from its choices or from the keys below it."""
    if _choice(model).startswith(f"{name}: "):
        return _first_paragraph(model)
    below = models_in(field.annotation)
    return _first_paragraph(below[0]) if len(below) == 1 else ""


def _first_paragraph(model: type[BaseModel]) -> str:
    return " ".join((inspect.getdoc(model) or "").split("\n\n")[0].split())


def _choice(model: type[BaseModel]) -> str:
    for name in ("kind", "shape", "mode", "method"):
        field = model.model_fields.get(name)
        if field is not None and get_origin(field.annotation) is Literal:
            (value, *others) = get_args(field.annotation)
            if not others:
                return f"{name}: {value}"
    return ""


def _is_list(annotation: Any) -> bool:
    if get_origin(annotation) is tuple:
        return Ellipsis in get_args(annotation)
    return any(_is_list(part) for part in get_args(annotation))


def _type(annotation: Any) -> str:
    origin, parts = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return _type(parts[0])
    if origin is Literal:
        return " or ".join(f"`{part}`" for part in parts)
    if origin in (Union, types.UnionType):
        return " or ".join(dict.fromkeys(_type(part) for part in parts))
    if origin is tuple:
        if Ellipsis in parts:
            return f"list of {_type(parts[0])}"
        inner = _type(parts[0])
        return f"{len(parts)} {inner}s" if inner.endswith("number") else f"{len(parts)} x {inner}"
    if origin is dict:
        return f"keys with {_type(parts[1])}"
    if annotation is type(None):
        return "null"
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return "section"
    return NAMES.get(annotation, getattr(annotation, "__name__", str(annotation)))


def _bounds(field: Any) -> tuple[str, str]:
    """Bounds and their reason, of a field or of what its type is made of."""
    metadata, reason, annotation = getattr(field, "__metadata__", ()), "", field
    if isinstance(field, FieldInfo):
        metadata, reason, annotation = field.metadata, field.description or "", field.annotation
    words: dict[str, str] = {}
    for bound in metadata:
        if isinstance(bound, FieldInfo):
            words["field"], why = _bounds(bound)
            reason = reason or why
        else:
            words |= _limits(bound)
    if words:
        return " ".join(filter(None, words.values())), reason
    for part in typing.get_args(annotation):
        inner, why = _bounds(part)
        if inner:
            return inner, reason or why
    return "", reason


def _limits(bound: Any) -> dict[str, str]:
    """One bound in words, by its name."""
    return {
        name: f"{sign} {value:,}" if isinstance(value, int) else f"{sign} {value:g}"
        for name, sign in (SIGNS | LENGTHS).items()
        if (value := getattr(bound, name, None)) is not None
    }


def _shown(field: FieldInfo) -> str:
    value = field.get_default(call_default_factory=True, validated_data={})
    if value is PydanticUndefined:
        return ""
    if isinstance(value, BaseModel):
        return "its defaults"
    if value is None:
        return "null"
    if isinstance(value, tuple):
        return "[" + ", ".join(f"{part}" for part in value) + "]"
    return str(value).lower() if isinstance(value, bool) else f"{value}"


@cache
def _docstrings(model: type[BaseModel]) -> dict[str, str]:
    """The texts under the fields of a class and its bases."""
    found: dict[str, str] = {}
    for base in reversed(model.__mro__):
        if not (issubclass(base, BaseModel) and base.__module__ != "pydantic.main"):
            continue
        body = ast.parse(textwrap.dedent(inspect.getsource(base))).body[0]
        assert isinstance(body, ast.ClassDef)
        for statement, after in zip(body.body, body.body[1:], strict=False):
            if not (
                isinstance(statement, ast.AnnAssign) and isinstance(statement.target, ast.Name)
            ):
                continue
            if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant):
                found[statement.target.id] = " ".join(str(after.value.value).split())
    return found
