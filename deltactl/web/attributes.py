"""How text that somebody else chose gets into an attribute of the page.

NiceGUI's `props("key=value")` parses a string, and a key that begins with a colon makes the browser
run its value as JavaScript. A file name, heading or robot name in such a string is therefore a
script in everybody's page. `tests/web/test_source_of_the_page.py` lets nothing but constants into
those strings; everything else goes through `attribute`, which never parses.
"""

from __future__ import annotations

import re
from typing import Any, TypeVar

from nicegui import ui

Part = TypeVar("Part", bound=ui.element)
TEXTS = re.compile(r"(aria|data)-[a-z-]+|alt|color|label|placeholder|title")
"""Attributes that the browser takes as text. A handler of an event, an address or a style is none,
and no name that begins with a colon."""


def attribute(part: Part, name: str, value: str | int | float | None) -> Part:
    """Set one attribute to a value as it is; None removes it.

    Raises ValueError for a name of which a browser could run the value.
    """
    if not TEXTS.fullmatch(name):
        raise ValueError(f"{name!r} is no attribute for text; see TEXTS")
    props: Any = part.props
    if props.get(name) != value:
        props.set_optional(name, value)
    return part


def marked(part: Part, mark: str) -> Part:
    """Give an element the name by which tests and scripts find it."""
    return attribute(part, "data-testid", mark)


def labelled(part: Part, text: str) -> Part:
    """Say to screen readers what an element is."""
    return attribute(part, "aria-label", text)


def tell_problem(text: str) -> None:
    """One line in red, until it is closed."""
    close = {"label": "Close", "color": "white"}
    ui.notify(text, type="negative", multi_line=True, timeout=12_000, actions=[close])
