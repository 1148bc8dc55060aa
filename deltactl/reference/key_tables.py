"""Sections of a file as tables in Markdown: one row a key, each section written once a page."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable, Iterator
from typing import Any

import yaml
from pydantic import BaseModel

from deltactl.reference.examples import example_of
from deltactl.reference.fields import ANY, Key, Section, sections

LONGEST_EXAMPLE = 70
"""A section that is longer is shown by its own keys."""
BELOW = "See below"
MOST_IN_A_CHOICE = 2
"""A section with more keys has a table of its own."""
COLUMNS = ("key and example", "value", "meaning")
Row = tuple[str, str, str]
SAID_BY_THE_UNIT = {
    "m": "metres",
    "kg": "kilograms",
    "s": "seconds",
    "BCM number": "BCM numbers of the 40-pin header",
    "BCM numbers": "BCM numbers of the 40-pin header",
    "sine": "a sine",
    "any number": "any whole number",
    "ratio": "a probability",
}


class KeyTables:
    """Tables of one page.

    A section that several places share is written at the first of them, and so is a key that
    several choices at one place share.
    """

    def __init__(self) -> None:
        self._written: set[type[BaseModel]] = set()
        self._rows: defaultdict[str, set[Row]] = defaultdict(set)
        """Keys at each place that has choices."""

    def of(self, model: type[BaseModel], file: str = "The file") -> list[str]:
        """Headings, sentences and tables of a file and its sections.

        Raises
        ------
        KeyError
            If a key has no example.
        """
        places: dict[type[BaseModel], list[Section]] = {}
        for section in sections(model):
            places.setdefault(section.model, []).append(section)
        parts: list[str] = []
        again: list[str] = []
        fresh: list[list[Section]] = []
        for inner, shared in places.items():
            if inner in self._written:
                again += [section.place for section in shared]
                continue
            self._written.add(inner)
            fresh.append(shared)
        for many in _together(fresh):
            parts += _choices(many) if len(many) > 1 else self._section(many[0], file)
        return [*parts, *_as_above(again)]

    def _section(self, shared: list[Section], file: str) -> list[str]:
        first, places = shared[0], _places(shared)
        choice = f", `{first.choice}`" if first.choice and places else ""
        rows = {key.name: _row(first, key) for key in first.keys if not first.is_chosen_by(key)}
        again = [name for name, row in rows.items() if row in self._rows[first.place]]
        if first.choice:
            self._rows[first.place].update(rows.values())
        fresh = _in_one_row([row for name, row in rows.items() if name not in again])
        parts = [f"### {places or file}{choice}"]
        if first.says and not (len(rows) == 1 and fresh[0][2] == first.says.rstrip(".")):
            parts.append(" ".join(first.says.split()))
        if fresh:
            parts.append(table(COLUMNS, fresh))
        return [*parts, *_as_above(again)]


def _as_above(names: Iterable[str]) -> list[str]:
    listed = ", ".join(f"`{name}`" for name in dict.fromkeys(names))
    return [f"{listed}: as above."] if listed else []


def _places(shared: Iterable[Section]) -> str:
    """The places in a file that have a section, the shortest first."""
    places = sorted({section.place for section in shared if section.place}, key=_by_length)
    return ", ".join(f"`{place}`" for place in places)


def _in_one_row(rows: Iterable[Row]) -> list[Row]:
    """Rows; neighbours that differ only in the key share one."""
    shared: list[Row] = []
    for row in rows:
        if shared and shared[-1][1:] == row[1:]:
            shared[-1] = (f"{shared[-1][0]}, {row[0]}", *row[1:])
        else:
            shared.append(row)
    return shared


def _together(found: list[list[Section]]) -> list[list[list[Section]]]:
    """Small sections at one place, of which a file has any, as one table; the others alone."""
    groups: dict[object, list[list[Section]]] = {}
    for number, shared in enumerate(found):
        first = shared[0]
        small = (
            first.place.endswith("[]") and not first.choice and len(first.keys) <= MOST_IN_A_CHOICE
        )
        groups.setdefault(first.place.split(".")[-1] if small else number, []).append(shared)
    return list(groups.values())


def _choices(many: list[list[Section]]) -> list[str]:
    """One table of sections that a place may hold: their first keys say which it is."""
    rows = []
    for shared in many:
        first, *others = (_row(shared[0], key) for key in shared[0].keys)
        does = " ".join(shared[0].says.split())
        rows += [(*first[:2], does if first[2] == BELOW else f"{does} {first[2]}"), *others]
    places = _places(section for shared in many for section in shared)
    return [f"### {places}", "One of these.", table(COLUMNS, rows)]


def _row(section: Section, key: Key) -> Row:
    example = example_of(section.model, key.name)
    shown = in_one_line(example)
    fits = len(shown) <= LONGEST_EXAMPLE
    name = f"`{key.name}: {shown}`" if fits else f"`{key.name}`"
    says = key.meaning if "section" not in key.type or key.own else BELOW
    meaning = _without_unit(says, key.unit).rstrip(".")
    # Names of fields and values keep their case.
    upper = meaning[:1].upper() if meaning[:2].islower() else meaning[:1]
    return name, ", ".join(_value(key, example)), upper + meaning[1:]


def _value(key: Key, example: Any) -> Iterator[str]:
    """Type, unit and bounds of a key, and its default where that is not the example."""
    kind = key.type.replace(" or null", "")
    unit = "" if key.unit in ("ratio", "count") else key.unit
    yield f"{kind} [{unit}]" if unit and "number" in kind else kind
    if key.bounds and key.bounds != ANY:
        yield _short(key.bounds, kind)
    if key.default == "required":
        yield "required"
    elif key.default not in ("null", "its defaults", "[]", "{}", ""):
        yield "default" if _same(key.default, example) else f"default {key.default}"


def _same(default: str, example: Any) -> bool:
    """Whether a default, as text, is the example: 5.0 is 5."""
    return bool(yaml.safe_load(default) == example)


def _by_length(place: str) -> tuple[int, str]:
    return len(place), place


def _short(bounds: str, kind: str) -> str:
    """Both bounds as a range; lengths with what they count."""
    if "at least" in bounds or "at most" in bounds:
        both = re.fullmatch(r"at least (\S+) at most (\S+)", bounds)
        counted = "characters" if kind == "text" else "entries"
        return f"{both[1]} to {both[2]} {counted}" if both else f"{bounds} {counted}"
    return bounds.removeprefix("from ") if " to " in bounds or " below " in bounds else bounds


def _without_unit(says: str, unit: str) -> str:
    """The sentence without a part that only repeats the unit."""
    repeated = {unit, SAID_BY_THE_UNIT.get(unit)}
    parts = [part for part in says.split("; ") if part not in repeated]
    return "; ".join(parts) or says


def in_one_line(value: Any) -> str:
    """A value in YAML, without a line break."""
    text = yaml.safe_dump(value, default_flow_style=True, width=10_000, sort_keys=False)
    return " ".join(text.removesuffix("...\n").split())


def table(columns: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A table in Markdown."""
    lines = [list(columns)]
    lines += [
        ["---"] * len(lines[0]),
        *([cell.replace("|", "\\|") for cell in row] for row in rows),
    ]
    head, rule, *body = lines
    return "\n".join(
        ["| " + " | ".join(head) + " |", "|" + "|".join(rule) + "|"]
        + ["| " + " | ".join(line) + " |" for line in body]
    )
