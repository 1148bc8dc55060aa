"""Job and robot files as browsers send them: looked at before anything reads them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from deltactl.foundation.errors import ConfigError
from deltactl.foundation.strict_yaml import Document
from deltactl.foundation.yaml_tree import Location

MAX_CHARACTERS = 60_000
"""What the daemon takes of a job's text."""
NAMING = ("robot", "record", "file", "include")
"""Keys of a job whose values name files, at any depth: steps have networks of their own."""


def kind_of(text: str) -> str:
    """'job' or 'robot'. Raises ConfigError for what a page may not send."""
    if len(text) > MAX_CHARACTERS:
        raise ConfigError(
            f"the text has {len(text):,} characters, and a page may send {MAX_CHARACTERS:,};"
            " put the file beside the daemon and use 'deltactl run'"
        )
    document = Document(Path("text"), text.replace("\r\n", "\n"))
    if "kind" in document.data and "path" not in document.data:
        return "robot"
    _refuse_paths(document, document.data, ())
    return "job"


def _refuse_paths(document: Document, value: Any, place: Location) -> None:
    """A page names files of the project; it does not reach for others."""
    inner = enumerate(value) if isinstance(value, list) else ()
    for key, child in value.items() if isinstance(value, dict) else inner:
        here = (*place, key)
        if key in NAMING and isinstance(child, str) and _has_folder(child):
            raise document.fail(here, "a job from the page names files without folders")
        _refuse_paths(document, child, here)


def _has_folder(name: str) -> bool:
    return "/" in name or "\\" in name or name.startswith(".")
