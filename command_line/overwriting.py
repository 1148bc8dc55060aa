"""Files that are there are not written over, unless somebody says so."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from foundation.errors import ConfigError

ForceOption = Annotated[bool, typer.Option("--force", help="Overwrite existing files.")]


def refuse_existing(force: bool, *paths: Path | None) -> None:
    """Raise ConfigError for files that would be written over; empty ones hold nothing to lose."""
    if force:
        return
    for path in paths:
        if path is not None and path.is_file() and path.stat().st_size:
            raise ConfigError(f"{path}: exists already; name another file, or add --force")
