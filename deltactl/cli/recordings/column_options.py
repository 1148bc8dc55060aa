"""The columns of a recording, as `--columns` and `--set` give them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from deltactl.foundation.errors import ConfigError

if TYPE_CHECKING:
    from deltactl.recording.foreign.mapping import Mapping


def mapping_of(columns: list[str]) -> Mapping:
    """Mapping files and single columns, as `--columns` and `--set` give them."""
    from deltactl.recording.foreign.mapping import load_mapping

    files = [one for one in columns if is_mapping_file(one)]
    if len(files) > 1:
        raise ConfigError(f"--columns: one mapping file at most, not {' and '.join(files)}")
    options = [one for one in columns if one not in files]
    return load_mapping(Path(files[0]) if files else None, options)


def is_mapping_file(option: str) -> bool:
    """Whether an option names a file of mappings, and not one column."""
    return "=" not in option or Path(option).is_file()
