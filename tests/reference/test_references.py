"""The reference pages and schemas are those of the code, and leave nothing out."""

from __future__ import annotations

import pytest

from deltactl.firmware_py.daemon.protocol import ARGUMENTS
from deltactl.recording.tables.flat import UNITS
from deltactl.reference.fields import sections
from deltactl.reference.words import ARGUMENT_WORDS, COLUMN_WORDS, REQUEST_WORDS, stem_of
from deltactl.reference.write import made
from tests.rigs.documented import ROOT


@pytest.mark.parametrize("path", made(), ids=lambda path: path.name)
def test_nothing_is_stale(path) -> None:
    assert path.read_text(encoding="utf-8") == made()[path], "type: make reference"


def test_nothing_is_left_over() -> None:
    """A page that is no longer made would never be stale."""
    there = {
        one
        for folder in ("docs/reference", "deltactl/schemas")
        for one in (ROOT / folder).iterdir()
    }
    assert there == set(made()), "delete what nothing makes"


def test_every_key_of_a_job_says_something() -> None:
    from deltactl.firmware_py.job_file import JobFile

    found = {f"{one.place}.{key.name}": key for one in sections(JobFile) for key in one.keys}
    assert found["path.radius_m"].unit == "m"
    assert found["path.radius_m"].bounds == "above 0 to 2"
    assert "no arm reaches further" in found["path.radius_m"].says
    assert found["timing.t_pwm_s"].default == "required"


def test_every_column_and_argument_is_in_words() -> None:
    assert {stem_of(name) for name in UNITS} == set(COLUMN_WORDS)
    assert set(ARGUMENTS) == set(REQUEST_WORDS)
    assert {name for one in ARGUMENTS.values() for name in one} == set(ARGUMENT_WORDS)


def test_every_cell_of_the_tables_of_keys_is_filled() -> None:
    """Bounds and units belong to numbers; all else stands at every key."""
    for page in ("jobs.md", "robots.md", "columns.md"):
        text = made()[ROOT / "docs" / "reference" / page].replace("\\|", "/")
        rows = [line.split(" | ") for line in text.splitlines() if line.count(" | ") == 6]
        keys = [row for row in rows if row[0].startswith("| `")]
        assert keys
        for name, kind, unit, bounds, default, example, says in keys:
            assert default or kind == "text", name  # an empty text is a default too
            assert example.strip(), name
            assert says.strip("| "), name
            if "number" in kind:
                assert unit, name
                assert bounds, name
