"""Which mistakes are put into the program, and by which tests each has to be noticed.

Known ones (named.yaml) come first, then ones made by rule, spread over files (table.yaml).
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import NamedTuple

import yaml


class Row(NamedTuple):
    """Files of a folder, so many mutants of each, and the tests of that folder."""

    folder: str
    files: dict[str, int]
    tests: list[str]


class Named(NamedTuple):
    """A known mistake: what it is, its file, what stands there, and what is put in its place."""

    what: str
    path: str
    was: str
    now: str


def _text(name: str) -> str:
    return Path(__file__).with_name(name).read_text(encoding="utf-8")


TABLE: tuple[Row, ...] = tuple(Row(**row) for row in yaml.safe_load(_text("table.yaml")))
NAMED: tuple[Named, ...] = tuple(Named(**row) for row in yaml.safe_load(_text("named.yaml")))
EQUIVALENT: dict[str, str] = json.loads(_text("equivalent.json"))
"""Survivors that are no mistakes, by name, each with the reason."""
