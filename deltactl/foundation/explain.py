"""What a pydantic error means for the person who wrote the file."""

from __future__ import annotations

import difflib
import re
from collections.abc import Container, Sequence
from typing import Any

from pydantic import BaseModel, ValidationError

from deltactl.foundation.schema_keys import reason_of, valid_keys, where_known
from deltactl.foundation.yaml_tree import Location

BOUNDS = (
    *("greater_than", "greater_than_equal", "less_than", "less_than_equal"),
    *("too_short", "too_long", "string_too_short", "string_too_long"),
)
"""The kinds of error that a bound causes; the field's description is the bound's reason."""


OTHERS: dict[str, tuple[str, dict[str, float]]] = {
    "_m": ("metres", {"m": 1.0, "mm": 1e-3, "cm": 1e-2}),
    "_s": ("seconds", {"s": 1.0, "ms": 1e-3, "us": 1e-6}),
    "_kg": ("kg", {"kg": 1.0, "g": 1e-3}),
    "_deg": ("degrees", {"deg": 1.0}),
    "_mps": ("m/s", {"m/s": 1.0, "mm/s": 1e-3}),
}
"""The units that keys end in, and what one of others is in them."""
LEAST_MM = 10.0
"""Lengths in metres, and speeds in m/s, from here on are rather mm."""
MOST_IN_MM = 4
"""So many of them are written out in m."""
EVIDENT, SIMILAR = 0.8, 0.5
"""How alike a misspelt key and the one meant are, beyond doubt and for want of another."""
_RATIO = re.compile(r"\s*(\d+(?:\.\d+)?)\s*[:/]\s*([1-9]\d*)\s*")
_WITH_UNIT = re.compile(r"\s*([-+]?[.\d]+(?:[eE][-+]?\d+)?)\s*([a-z/]+)\s*")


def explain_all(
    model: type[BaseModel], error: ValidationError, in_file: Container[Location]
) -> list[tuple[Location, str]]:
    """Where each mistake stands and what to say about it; `in_file` holds all places of the file.

    What follows from another mistake is left out: the key that is missing where one is misspelt,
    and what the other members of a union say of the same value.
    """
    left = error.errors(include_url=False)
    mistakes, in_mm = [], []
    while left:
        found = _worst(left, in_file)
        place = _place(found["loc"], in_file)
        if is_mm(place, found):
            in_mm.append((place, found["input"] / 1e3))
        else:
            mistakes.append(_explained(model, found, in_file))
        left = [one for one in left if one is not found and not _same(found, one, in_file)]
        if found["type"] == "extra_forbidden":
            left = _without_the_meant(found["loc"], left)
    return [*mistakes, *_metres(in_mm)]


def explain(
    model: type[BaseModel], error: ValidationError, in_file: Container[Location]
) -> tuple[Location, str]:
    """The worst of the mistakes alone."""
    return explain_all(model, error, in_file)[0]


def _same(found: Any, other: Any, in_file: Container[Location]) -> bool:
    """Whether another error is about the same value; keys that are missing are their own."""
    if _lacks_a_key(found) or _lacks_a_key(other):
        return bool(other["loc"] == found["loc"])
    place, beside = _place(found["loc"], in_file), _place(other["loc"], in_file)
    return bool(beside) and (beside == place[: len(beside)] or place == beside[: len(place)])


def _lacks_a_key(error: Any) -> bool:
    return bool(error["type"] == "missing" and isinstance(error["loc"][-1], str))


def _without_the_meant(misspelt: Location, errors: list[Any]) -> list[Any]:
    """The errors less that of the one missing key beside a misspelt one that was meant by it."""
    missing = [
        one for one in errors if one["type"] == "missing" and one["loc"][:-1] == misspelt[:-1]
    ]
    names = [str(one["loc"][-1]) for one in missing]
    close = difflib.get_close_matches(str(misspelt[-1]), names, n=1, cutoff=0.5)
    meant = [one for one in missing if str(one["loc"][-1]) in close]
    return [one for one in errors if one not in (meant or missing[:1])]


def _explained(
    model: type[BaseModel], found: Any, in_file: Container[Location]
) -> tuple[Location, str]:
    place = _place(found["loc"], in_file)
    kind = found["type"]
    if kind == "extra_forbidden":
        return place, f"unknown key{_meant(model, found['loc'], place)}"
    if kind == "missing":
        part = found["loc"][-1]
        return place, f"item {part + 1} is missing" if isinstance(
            part, int
        ) else f"'{part}' is missing"
    if kind == "union_tag_not_found" and (told := _no_member(model, found, place)):
        return told
    if kind.startswith("union_tag"):
        return _wrong_choice(found, place, in_file)
    said = found["msg"].removeprefix("Value error, ") + _got(found)
    reason = reason_of(model, found["loc"]) if kind in BOUNDS else None
    return place, (f"{said}: {reason}" if reason else said) + in_its_unit(place, found)


def in_its_unit(place: Location, found: Any) -> str:
    """What a value would be in the unit of its key's name; empty where it tells no other unit."""
    key = next((part for part in reversed(place) if isinstance(part, str)), "")
    suffix = next((part for part in OTHERS if key.endswith(part)), "")
    name, others = OTHERS.get(suffix, ("", {}))
    value = found["input"]
    if isinstance(value, str) and (said := _WITH_UNIT.fullmatch(value)) and said[2] in others:
        return f"; write it in {name} and without the unit, {float(said[1]) * others[said[2]]:.6g}"
    if isinstance(value, str) and (ratio := _RATIO.fullmatch(value)):
        return f"; a ratio is one number, {float(ratio[1]) / float(ratio[2]):.6g}"
    return ""


def is_mm(place: Location, found: Any) -> bool:
    """Whether a length in m, or a speed in m/s, beyond its bound is evidently one in mm."""
    key = next((part for part in reversed(place) if isinstance(part, str)), "")
    value = found["input"]
    beyond = found["type"].startswith(("less_than", "greater_than"))
    number = isinstance(value, int | float) and abs(value) >= LEAST_MM
    return bool(beyond and number and key.endswith(("_m", "_mps")))


def _metres(in_mm: Sequence[tuple[Location, float]]) -> list[tuple[Location, str]]:
    """One line for all of them, at the first: whoever writes one in mm writes them all so."""
    if not in_mm:
        return []
    in_mm = sorted(in_mm, key=lambda one: [str(part) for part in one[0]])
    place, first = in_mm[0]
    units = [
        unit
        for end, unit in (("_m", "metres"), ("_mps", "m/s"))
        if any(str(part).endswith(end) for where, _ in in_mm for part in where)
    ]
    others = [
        f"{value:.6g} for {'.'.join(map(str, where))}" for where, value in in_mm[1:MOST_IN_MM]
    ]
    if len(in_mm) > MOST_IN_MM:
        others.append(f"{len(in_mm) - MOST_IN_MM} more likewise")
    also = f" (and {', '.join(others)})" if others else ""
    return [(place, f"this is in {' or '.join(units)}, not in mm: write {first:.6g}{also}")]


def _worst(errors: Sequence[Any], in_file: Container[Location]) -> Any:
    """The one error to report first."""
    # A misspelt key is also a missing one: the misspelling is what the user can see.
    found = sorted(errors, key=lambda one: one["type"] != "extra_forbidden")
    place = _place(found[0]["loc"], in_file)
    # Of the errors that the members of a union give for one value, the innermost says most.
    places = [(_place(one["loc"], in_file), one) for one in found]
    same = [(where, one) for where, one in places if where[: len(place)] == place]
    return max(same, key=lambda each: (len(each[0]), not each[1]["type"].endswith("_type")))[1]


def _place(loc: Location, in_file: Container[Location]) -> Location:
    """A pydantic location without the parts that are no keys of the file (members of unions).

    A member may be named as a key beside the one that leads on, as `repeat` is beside its `steps`:
    of all ways to read the location the longest is meant.
    """
    ways: list[Location] = [()]
    for part in loc:
        ways += [
            (*way, part) for way in ways if (*way, part) in in_file and (*way, part) not in ways
        ]
    return max(ways, key=lambda way: (len(way), way[-1:] == loc[-1:]))


def _no_member(model: type[BaseModel], found: Any, place: Location) -> tuple[Location, str] | None:
    """Of a section that one of several keys names: which key it has instead. None of another."""
    value, valid = found["input"], valid_keys(model, found["loc"])
    if not place or not isinstance(place[-1], int) or not isinstance(value, dict) or not value:
        return None
    key = next(iter(value))
    if key in valid:
        return None
    return (*place, key), f"unknown key{_meant(model, (*found['loc'], key), (*place, key))}"


def _wrong_choice(
    found: Any, place: Location, in_file: Container[Location]
) -> tuple[Location, str]:
    # A function that picks the member is named after its key: `mode()`.
    key = found["ctx"]["discriminator"].strip("'()")
    if found["type"] == "union_tag_not_found":
        return place, f"'{key}' is missing" if (*place, key) not in in_file else f"'{key}' is empty"
    if (*place, key) in in_file:
        place = (*place, key)
    choices = found["ctx"]["expected_tags"].replace("'", "").split(", ")
    given = found["ctx"]["tag"]
    return place, f"must be one of {', '.join(choices)} (got {_short(given)})"


def _got(found: Any) -> str:
    value = found["input"]
    if isinstance(value, dict | list) or found["type"] == "value_error":
        return ""
    return f" (got {_short(value)})"


def _short(value: object) -> str:
    shown = repr(value)
    return shown if len(shown) <= 60 else shown[:57] + "..."


def _meant(model: type[BaseModel], loc: Location, place: Location) -> str:
    """What an unknown key may be: another name in its section, or a key of another section."""
    key, valid = str(place[-1]), valid_keys(model, loc[:-1])
    for least in (EVIDENT, SIMILAR):
        close = difflib.get_close_matches(key, valid, n=1, cutoff=least)
        if close:
            return f"; did you mean '{close[0]}'?"
        sections = tuple(str(part) for part in place[:-1] if isinstance(part, str))
        if least == EVIDENT and (belongs := where_known(model, key, sections)):
            return f" here; it belongs {belongs}"
    return f"; valid keys: {', '.join(valid)}" if valid else ""
