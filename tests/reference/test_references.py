"""The reference pages and schemas are those of the code, and leave nothing out."""

from __future__ import annotations

import re
from functools import cache

import pytest
from pydantic import BaseModel

from deltactl.firmware_py.daemon.protocol import ARGUMENTS
from deltactl.firmware_py.job_file import JobFile
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.models.robot import KINDS
from deltactl.recording.foreign.mapping import Mapping
from deltactl.recording.tables.flat import UNITS
from deltactl.reference import write
from deltactl.reference.fields import sections
from deltactl.reference.words import ARGUMENT_WORDS, COLUMN_WORDS, REQUEST_WORDS, stem_of, unit_of
from tests.rigs.documented import ROOT

made = cache(write.made)
WITHOUT = ("ratio", "count")
"""Units that a table leaves out: the number has none."""
KEY = re.compile(r"(?:^|, )`(\w+)(?=`|:)")
"""Keys in a cell; alike ones share a row."""
ANYTHING = ("scale", "offset", "value", "zero_rad")
"""Keys of a mapping, and a place on an axis that turns without end: any number will do."""


def test_nothing_is_stale() -> None:
    pages = made().items()
    stale = [one.name for one, text in pages if one.read_text(encoding="utf-8") != text]
    assert stale == [], "type: make reference"


def test_nothing_is_left_over() -> None:
    """A page that is no longer made would never be stale."""
    there = {
        one
        for folder in ("docs/reference", "deltactl/schemas")
        for one in (ROOT / folder).iterdir()
    }
    assert there == set(made()), "delete what nothing makes"


def test_every_key_of_a_job_says_something() -> None:
    found = {f"{one.place}.{key.name}": key for one in sections(JobFile) for key in one.keys}
    assert found["path.radius_m"].unit == "m"
    assert found["path.radius_m"].bounds == "above 0 to 2"
    assert "no arm reaches further" in found["path.radius_m"].says
    assert found["timing.t_pwm_s"].default == "required"


def test_every_column_and_argument_is_in_words() -> None:
    assert {stem_of(name) for name in UNITS} == set(COLUMN_WORDS)
    assert set(ARGUMENTS) == set(REQUEST_WORDS)
    assert {name for one in ARGUMENTS.values() for name in one} == set(ARGUMENT_WORDS)


def test_every_key_has_an_example_a_value_and_a_meaning() -> None:
    """A number says its bounds, and its unit where it has one."""
    for page in ("jobs.md", "robots.md", "columns.md", "socket.md"):
        text = made()[ROOT / "docs" / "reference" / page].replace("\\|", "/")
        tables = [part for part in text.split("\n\n") if part.startswith(("| key", "| argument"))]
        assert tables
        for row in [line.strip("| ") for table in tables for line in table.splitlines()[2:]]:
            name, value, meaning = row.split(" | ")
            assert meaning
            assert ": " in name or "section" in value, name
            for key in KEY.findall(name):
                if "number" in value and key not in ANYTHING:
                    assert re.search(r" to |from|above|below|those of the effect", value), name
                    assert "[" in value or not unit_of(key) or unit_of(key) in WITHOUT, name


@pytest.mark.parametrize("model", [JobFile, RobotFile, *KINDS.values(), Mapping])
def test_every_key_is_on_its_page(model: type[BaseModel]) -> None:
    pages = [text for path, text in made().items() if path.parent.name == "reference"]
    first_cells = [
        one for text in pages for one in re.findall(r"^\| (`.*?`) \|", text, re.MULTILINE)
    ]
    shown = {key for cell in first_cells for key in KEY.findall(cell)}
    constant = {"kind", "shape", "mode"}
    """What a heading names."""
    keys = {key.name for one in sections(model) for key in one.keys}
    assert keys - shown <= constant
