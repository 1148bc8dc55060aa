"""What a pydantic error means for the person who wrote the file."""

from __future__ import annotations

import difflib
import re
from collections.abc import Container, Sequence
from dataclasses import dataclass
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
ERRORS_EACH = 10
"""So many errors are looked at for each mistake: the members of a union say one each."""
LONGEST_KEY = 60
"""No key of a schema is that long, and the search for a name near a long one takes long."""
Mistake = tuple[Location, str]
EVIDENT, SIMILAR = 0.8, 0.5
"""How alike a misspelt key and the one meant are, beyond doubt and for want of another."""
_RATIO = re.compile(r"\s*(\d+(?:\.\d+)?)\s*[:/]\s*([1-9]\d*)\s*")
_WITH_UNIT = re.compile(r"\s*([-+]?[.\d]+(?:[eE][-+]?\d+)?)\s*([a-z/]+)\s*")


@dataclass(frozen=True, slots=True)
class Found:
    """One mistake: where it is, and the error of pydantic that says most of it."""

    place: Location
    error: Any
    in_mm: tuple[tuple[Location, float], ...] = ()
    """All the lengths in mm of a file, which are one mistake, in metres."""

    def says(self, model: type[BaseModel], in_file: Container[Location]) -> Mistake:
        """What to say about it, and of which place."""
        return _metres(self.in_mm) if self.in_mm else _explained(model, self.error, in_file)


def mistakes_in(errors: Sequence[Any], in_file: Container[Location], most: int) -> list[Found]:
    """The mistakes behind the errors of pydantic, about `most` at most; `in_file` holds all places
    of the file.

    What follows from another mistake is left out: the key that is missing where one is misspelt,
    and what the other members of a union say of the same value. Takes time in proportion to the
    errors and to `most` squared, so a file with a mistake in every row holds nobody up.
    """
    # A misspelt key is also a missing one: the misspelling is what the user can see.
    ordered = sorted(errors, key=lambda error: error["type"] != "extra_forbidden")
    left = [Found(_place(error["loc"], in_file), error) for error in ordered[: most * ERRORS_EACH]]
    found: list[Found] = []
    in_mm: list[tuple[Location, float]] = []
    while left and len(found) < most:
        worst = _worst(left)
        if is_mm(worst.place, worst.error):
            in_mm.append((worst.place, worst.error["input"] / 1e3))
        else:
            found.append(worst)
        left = [other for other in left if other is not worst and not _same(worst, other)]
        if worst.error["type"] == "extra_forbidden":
            left = _without_the_meant(worst.error["loc"], left)
    if in_mm:
        in_mm.sort(key=lambda entry: [str(part) for part in entry[0]])
        found.append(Found(in_mm[0][0], None, tuple(in_mm)))
    return found


def explain(
    model: type[BaseModel], error: ValidationError, in_file: Container[Location]
) -> Mistake:
    """The worst of the mistakes alone."""
    worst = mistakes_in(error.errors(include_url=False), in_file, 1)[0]
    return worst.says(model, in_file)


def _same(found: Found, other: Found) -> bool:
    """Whether another error is about the same value; keys that are missing are their own."""
    if _lacks_a_key(found.error) or _lacks_a_key(other.error):
        return bool(other.error["loc"] == found.error["loc"])
    place, beside = found.place, other.place
    return bool(beside) and (beside == place[: len(beside)] or place == beside[: len(place)])


def _lacks_a_key(error: Any) -> bool:
    return bool(error["type"] == "missing" and isinstance(error["loc"][-1], str))


def _without_the_meant(misspelt: Location, left: list[Found]) -> list[Found]:
    """The errors less that of the one missing key beside a misspelt one that was meant by it."""
    missing = [
        found
        for found in left
        if found.error["type"] == "missing" and found.error["loc"][:-1] == misspelt[:-1]
    ]
    if not missing:
        return left
    names = [str(found.error["loc"][-1]) for found in missing]
    close = _nearest(str(misspelt[-1]), names, SIMILAR)
    meant = [id(found) for found in missing if str(found.error["loc"][-1]) == close] or [
        id(missing[0])
    ]
    return [found for found in left if id(found) not in meant]


def _nearest(key: str, names: list[str], least: float) -> str | None:
    """The name most like a key; None for want of one, and for a key that is longer than names."""
    if len(key) > LONGEST_KEY:
        return None
    return next(iter(difflib.get_close_matches(key, names, n=1, cutoff=least)), None)


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


def _metres(in_mm: Sequence[tuple[Location, float]]) -> Mistake:
    """One line for all of them, at the first: whoever writes one in mm writes them all so."""
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
    return place, f"this is in {' or '.join(units)}, not in mm: write {first:.6g}{also}"


def _worst(left: Sequence[Found]) -> Found:
    """The one to report first."""
    # When all members of a union report errors for one value, the innermost says most.
    place = left[0].place
    same = [found for found in left if found.place[: len(place)] == place]
    return max(
        same, key=lambda found: (len(found.place), not found.error["type"].endswith("_type"))
    )


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
    """Which key a section has instead of the one that selects its kind; None for other errors."""
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
        if close := _nearest(key, valid, least):
            return f"; did you mean '{close}'?"
        sections = tuple(str(part) for part in place[:-1] if isinstance(part, str))
        if least == EVIDENT and (belongs := where_known(model, key, sections)):
            return f" here; it belongs {belongs}"
    return f"; valid keys: {', '.join(valid)}" if valid else ""
