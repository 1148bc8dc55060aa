"""Commands as README and docs give them, to be held against the program or typed verbatim.

A fence that begins with ```sh is typed on a PC, line by line, on a clean clone. One word after it
says why it is not: `pi` (needs a Raspberry Pi, or root), `long` (hours, or the tests themselves),
`yours` (needs a file of the reader's). So too with commands that are set off by four spaces.
Which of those are typed elsewhere, and why the others are not: tests/newcomer/untyped.py.
"""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
_FENCE = re.compile(r"```(?P<language>\w*) ?(?P<why>\w*)")
_INDENTED = re.compile(r"    (?=(?:deltactl|make|python|pytest|pip|pipx|sudo|git|echo|source) )")
_INLINE = re.compile(r"`((?:sudo )?(?:\S*/)?(?:deltactl|make|pytest|python -m|python) [^`]+)`")


@dataclass(frozen=True)
class Documented:
    """One command: where it stands, its text without a comment, and why it is not typed."""

    page: Path
    line: int
    text: str
    why: str

    @property
    def words(self) -> list[str]:
        """The command's words, without `sudo` and the folder of the program."""
        words = shlex.split(self.text)
        words = words[1:] if words[0] == "sudo" else words
        return [words[0].rsplit("/", 1)[-1], *words[1:]]

    def __str__(self) -> str:
        return f"{self.page.relative_to(ROOT)}:{self.line}: {self.text}"


def fenced(page: Path) -> list[Documented]:
    """The lines of a page's ```sh fences, and the commands that four spaces set off."""
    found: list[Documented] = []
    language = why = ""
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
        if fence := _FENCE.match(line.strip()):
            language, why = ("", "") if language else (fence["language"] or "text", fence["why"])
        elif language == "sh" and (text := line.split("  #")[0].strip()):
            found.append(Documented(page, number, text, why))
        elif not language and _INDENTED.match(line):
            found.append(Documented(page, number, line.split("  #")[0].strip(), "indented"))
    return found


def blocks(page: Path, *languages: str) -> list[tuple[str, str]]:
    """Language and text of a page's fences in these languages, in their order."""
    found: list[tuple[str, list[str], int]] = []
    inside = False
    for line in page.read_text(encoding="utf-8").splitlines():
        if fence := _FENCE.match(line.strip()):
            inside = not inside
            if inside:
                found.append((fence["language"], [], len(line) - len(line.lstrip())))
        elif inside:
            found[-1][1].append(line[found[-1][2] :])
    return [(kind, "\n".join(lines)) for kind, lines, _ in found if kind in languages]


def inline(page: Path) -> list[Documented]:
    """Commands between back quotes in a page's sentences."""
    return [
        Documented(page, number, text, "inline")
        for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1)
        for text in _INLINE.findall(line)
    ]
