"""Words that users read: old phrases stay out of README, changelog and docs."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest
import yaml

from tests.rigs.documented import PAGES, ROOT

LIST = yaml.safe_load(Path(__file__).with_name("words.yaml").read_text(encoding="utf-8"))
READ = [*PAGES, ROOT / "CHANGELOG.md"]
_CODE = re.compile(r"```.*?```|`[^`\n]*`|\]\([^)]*\)", re.DOTALL)


def found_in(text: str) -> dict[str, str]:
    """Old phrases of a text, each with the better words."""
    prose = _CODE.sub("", text)
    found: dict[str, str] = {}
    for phrase, better in LIST["phrases"].items():
        for match in re.finditer(phrase, prose, re.MULTILINE):
            found[match.group().strip()] = better
    return found


@pytest.mark.parametrize("page", READ, ids=lambda page: str(page.relative_to(ROOT)))
def test_a_page_has_no_old_phrase(page: Path) -> None:
    found = found_in(page.read_text(encoding="utf-8"))
    allowed = set(LIST["allowed"].get(str(page.relative_to(ROOT)), ()))
    assert {phrase: better for phrase, better in found.items() if phrase not in allowed} == {}
    assert allowed <= set(found), "mended: take it off the list"


@pytest.mark.parametrize("text", ["A concealed fault.", "The mismatch of a run.", "A rival."])
def test_an_old_phrase_is_found(text: str) -> None:
    assert found_in(text)
    assert not found_in(f"`{text}`")


def test_the_docs_stay_short() -> None:
    """All pages together, as `wc -w` counts: what people write, and the reference."""
    pages = [page for page in PAGES if page.is_relative_to(ROOT / "docs")]
    words = sum(len(page.read_text(encoding="utf-8").split()) for page in pages)
    assert words <= LIST["most_words_in_docs"], f"{words} words"
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) <= 120


PARTS = ("deltactl", "drivers", "firmware_py", "models")


def folders() -> dict[str, list[Path]]:
    """Source files by folder; not the links inside `deltactl/`, nor the list of old commands."""
    found: dict[str, list[Path]] = {}
    for part in PARTS:
        for file in sorted((ROOT / part).rglob("*.py")):
            if file.resolve() == file.absolute() and file.name != "old_spellings.py":
                found.setdefault(str(file.parent.relative_to(ROOT)), []).append(file)
    return found


def sentences(file: Path) -> list[str]:
    """Texts with a space in them: docstrings, help and messages."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    constants = [node.value for node in ast.walk(tree) if isinstance(node, ast.Constant)]
    return [value for value in constants if isinstance(value, str) and " " in value]


def test_strings_of_the_mended_folders_have_no_old_phrase() -> None:
    left = set(LIST["folders_left"])
    old: dict[str, set[str]] = {}
    for folder, files in folders().items():
        phrases = {one for file in files for text in sentences(file) for one in found_in(text)}
        if phrases:
            old[folder] = phrases
    assert {folder: found for folder, found in old.items() if folder not in left} == {}
    assert left <= set(old), "mended: take them off the list"
