"""Which keys a schema knows: in a section, elsewhere, and why their values are bounded."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from functools import cache
from itertools import islice
from typing import Any, get_args

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from deltactl.foundation.yaml_tree import Location

MOST_PLACES = 3
"""So many sections that know a key are named."""


def valid_keys(model: type[BaseModel], loc: Location) -> list[str]:
    """Field names valid at `loc`, following nested models and tagged unions."""
    candidates: list[Any] = [model]
    before: str | int = ""
    for part in loc:
        candidates, before = _next(candidates, before, part), part
    return sorted({name for found in candidates for name in getattr(found, "model_fields", {})})


def reason_of(model: type[BaseModel], loc: Location) -> str | None:
    """Why the value at `loc` is bounded: the description nearest to it, None where it has none."""
    candidates: list[Any] = [model]
    reason = None
    before: str | int = ""
    for part in loc:
        fields = [
            candidate.model_fields[part]
            for candidate in candidates
            if part in getattr(candidate, "model_fields", {})
        ]
        if fields:
            reason = next(filter(None, map(_reason, fields)), None)
        candidates, before = _next(candidates, before, part), part
    return reason


def _reason(annotated: Any) -> str | None:
    """The description of a field, or of what its type is made of."""
    own = annotated.description if isinstance(annotated, FieldInfo) else None
    inner = annotated.annotation if isinstance(annotated, FieldInfo) else annotated
    within = (*getattr(inner, "__metadata__", ()), *getattr(inner, "__args__", ()))
    return own or next(filter(None, map(_reason, within)), None)


def where_known(model: type[BaseModel], key: str, section: tuple[str, ...]) -> str:
    """Where a key belongs that `section` does not know: 'at the top level ...', "in 'timing'".

    Of several places those that lie least deep; empty where nothing knows the key.
    """
    known = [(place, owner) for place, owner in _sections(model) if key in owner.model_fields]
    least = min((len(place) for place, _ in known), default=0)
    nearest = {place: owner for place, owner in known if len(place) == least}
    if section in nearest:
        tag = _tag_of(nearest[section])
        return f"to {tag}" if tag else ""
    if () in nearest:
        return "at the top level of the file, without indentation"
    return " or ".join(f"in '{'.'.join(place)}'" for place in list(nearest)[:MOST_PLACES])


def first_parts(value: Any, most: int, model: type[BaseModel]) -> Any:
    """Values of a file with at most `most` entries of each list and section.

    Keys that the schema knows, in whatever section, are kept beyond that.
    """
    return _first_parts(value, most, _keys_anywhere(model))


def _first_parts(value: Any, most: int, kept: frozenset[str]) -> Any:
    if isinstance(value, list):
        return [_first_parts(part, most, kept) for part in value[:most]]
    if not isinstance(value, dict):
        return value
    first = set(islice(value, most)) | (kept & value.keys())
    return {key: _first_parts(inner, most, kept) for key, inner in value.items() if key in first}


@cache
def _keys_anywhere(model: type[BaseModel]) -> frozenset[str]:
    return frozenset(name for _, owner in _sections(model) for name in owner.model_fields)


def _sections(model: type[BaseModel]) -> Iterator[tuple[tuple[str, ...], type[BaseModel]]]:
    """Every section of a schema and its model, the least deep first, each model once."""
    waiting: deque[tuple[tuple[str, ...], type[BaseModel]]] = deque([((), model)])
    seen: set[type[BaseModel]] = set()
    while waiting:
        place, owner = waiting.popleft()
        if owner in seen:
            continue
        seen.add(owner)
        yield place, owner
        for name, field in owner.model_fields.items():
            waiting.extend(((*place, name), inner) for inner in models_in(field.annotation))


def _tag_of(owner: type[BaseModel]) -> str:
    """What tells this member of a union from the others: 'mode together'."""
    for name, field in owner.model_fields.items():
        match get_args(field.annotation):
            case (str(value),):
                return f"{name} {value}"
    return ""


def _next(candidates: Sequence[Any], before: str | int, part: str | int) -> list[Any]:
    """Where a part leads from several models; behind a number it may be a member's own key, which
    names it, as `repeat` does among the steps of a job.
    """
    named = [model for model in candidates if part in getattr(model, "model_fields", {})]
    if named and isinstance(before, int) and len(candidates) > 1:
        return named
    return [inner for candidate in candidates for inner in _step_into(candidate, part)]


def _step_into(candidate: Any, part: str | int) -> list[Any]:
    fields = getattr(candidate, "model_fields", {})
    if part in fields:
        return models_in(fields[part].annotation)
    return [candidate] if _carries_tag(candidate, part) or isinstance(part, int) else []


def _carries_tag(candidate: Any, part: str | int) -> bool:
    """Whether `part` is the discriminator value (or class name) of this union member, or names a
    list of them, as `tuple[Drive, ...]` does.
    """
    if part == getattr(candidate, "__name__", None) or "[" in str(part):
        return True
    for field in getattr(candidate, "model_fields", {}).values():
        if part in getattr(field.annotation, "__args__", ()):
            return True
    return False


def models_in(annotation: Any) -> list[type[BaseModel]]:
    """The models that a value may be, each once."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    parts = getattr(annotation, "__args__", ())
    return list(dict.fromkeys(found for inner in parts for found in models_in(inner)))
