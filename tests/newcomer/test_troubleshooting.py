"""The page of messages quotes what the program really says."""

from __future__ import annotations

import re

import pytest

from tests.rigs.documented import ROOT

PAGE = (ROOT / "docs" / "troubleshooting.md").read_text(encoding="utf-8")
ROWS = [line.split("|")[1] for line in PAGE.splitlines() if line.startswith("| `")]
FOLDERS = ("firmware_py", "models", "drivers", "deltactl")
JOINED = re.compile(r'"\s*(?:#[^\n]*)?\n\s*f?"')
SOURCES = [
    JOINED.sub("", file.read_text(encoding="utf-8"))
    for folder in FOLDERS
    for file in sorted((ROOT / folder).rglob("*.py"))
] + [
    re.sub(r"\s*\n\s+", " ", file.read_text(encoding="utf-8"))
    for folder in FOLDERS
    for file in sorted((ROOT / folder).rglob("*.yaml"))
]
SHORTEST = 6


def fragments(quoted: str) -> list[str]:
    """The parts of a quoted message that do not stand for something of the reader's."""
    parts = re.split(r"\.\.\.|\b[A-Z]{3,}\b:?|scipy|diagnose|cannot run: |off$", quoted)
    return [part.strip(" .;:") for part in parts if len(part.strip(" .;:")) >= SHORTEST]


def test_it_has_ten() -> None:
    assert len(ROWS) >= 10


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row[:50])
def test_the_program_says_it(row: str) -> None:
    quoted = re.findall(r"`([^`]+)`", row)
    for part in [part for one in quoted for part in fragments(one)]:
        assert any(part in source for source in SOURCES), part
