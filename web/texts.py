"""Job and robot files as browsers send them: looked at before anything reads them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from foundation.errors import ConfigError
from foundation.strict_yaml import Document

MAX_CHARACTERS = 60_000
"""What the daemon takes of a job's text."""
NAMING: tuple[tuple[str, ...], ...] = (("robot",), ("record",), ("inverse_kinematics", "file"))
"""Keys of a job whose values name files."""


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
    for keys in NAMING:
        _refuse_paths(document, keys)
    return "job"


def _refuse_paths(document: Document, keys: tuple[str, ...]) -> None:
    """A page names files of the project; it does not reach for others."""
    value: Any = document.data
    for key in keys:
        value = value.get(key) if isinstance(value, dict) else None
    if isinstance(value, str) and ("/" in value or "\\" in value or value.startswith(".")):
        raise document.fail(keys, "a job from the page names files without folders")
