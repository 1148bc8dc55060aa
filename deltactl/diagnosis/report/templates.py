"""The sentences of the report as data: templates by topic and key, from `sentences.yaml`.

A module of the report picks a template by a field, or by a case, of the answer and fills it in.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

import yaml

FILE = "sentences.yaml"


@cache
def templates() -> Mapping[str, str]:
    """Every template by its key, 'topic.key'; texts of `ways` with the way before."""
    text = (files("deltactl.diagnosis.report") / FILE).read_text(encoding="utf-8")
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    return dict(_flat(yaml.load(text, loader)))


def _flat(table: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, str]]:
    for key, value in table.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{above}{key}.")
        else:
            yield f"{above}{key}", value


def say(key: str, *values: object, **named: object) -> str:
    """The template of this key, filled in. Raises KeyError where there is none."""
    return templates()[key].format(*values, **named)


def numbered(topic: str, name: str) -> str:
    """The template of a name that may end in a number or a direction; empty where there is none.

    'theta_2' is looked for as it is, then as 'theta_123' with 2.
    """
    found = templates().get(f"{topic}.{name}")
    for ends in ("123", "xyz"):
        if found is None and name[-1:] in ends:
            found = templates().get(f"{topic}.{name[:-1]}{ends}")
    return found.format(name[-1:]) if found and name else ""


class Signed(float):
    """A number whose format is two words: for above nothing, and for below."""

    def __format__(self, words: str) -> str:
        above, below = words.split("|")
        return below if self < 0.0 else above


@dataclass(frozen=True, slots=True)
class Ways:
    """How what an answer proposes is done: by options in a terminal, by buttons on a page, by
    methods in Python. An empty text: it is not offered.
    """

    save: str
    """What writes the corrected robot file."""
    save_all: str
    """The same with findings that are not certain."""
    job: str
    """What writes the job of the proposed run."""
    or_effort: str
    """How the effort would distinguish causes, after another way; empty where nothing reads one."""
    table: str
    """What has the numbers of a table."""
    rest: str
    """Where all is that one screen has no room for; {more} is a number of further steps."""
    rows: float = math.inf
    """Findings, from the first on, that have a row where this is read."""


def _ways(kind: str) -> Ways:
    head = f"ways.{kind}."
    own = {key.removeprefix(head): text for key, text in templates().items() if head in key}
    return Ways(**own, rows=math.inf)


TERMINAL, PAGE, PYTHON = _ways("terminal"), _ways("page"), _ways("python")
