"""Sentences in a narrow window: what is broken goes on under its own beginning."""

from __future__ import annotations

import re
from collections.abc import Iterable

from rich.text import Text

from deltactl.cli.output import console

_LEAD = re.compile(r"\s*(?:- |\d+\. )?")
"""What stands before a sentence: spaces, a bullet, a number."""
_TOGETHER = re.compile(r"((?<!\S)[(+\u2212-]?[\d.]+) (?=[^\W\d]|%)|\u00a0")
"""Between a number and its unit, and between thousands, no line is broken."""
_KEPT = "\ue000"
NARROWEST = 20


def print_wrapped(lines: Iterable[str]) -> None:
    """Print lines of rich markup, each broken at the window's edge with a hanging indent."""
    for line in lines:
        for part in wrapped(Text.from_markup(line), console.width):
            console.print(part, soft_wrap=True)


def wrapped(text: Text, width: int) -> list[Text]:
    """A line as lines of at most `width` characters, wherever words are no longer than that."""
    found = _LEAD.match(text.plain)
    indent = found.end() if found else 0
    if indent == len(text) or width - indent < NARROWEST:
        return [text]
    lead, body = text.divide([indent]) if indent else (Text(), text)
    body.plain = _TOGETHER.sub(lambda found: (found[1] or "") + _KEPT, body.plain)
    made = []
    for number, part in enumerate(body.wrap(console, width - indent)):
        part.rstrip()
        part.plain = part.plain.replace(_KEPT, " ")
        made.append(Text.assemble(Text(" " * indent) if number else lead, part))
    return made
