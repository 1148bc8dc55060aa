"""Robot files of the reader's own in the folder where a command is typed: to propose one."""

from __future__ import annotations

from pathlib import Path

import yaml

MOST_LOOKED_AT = 100
"""Files looked into: a message must not wait for a folder full of YAML."""
EXAMPLE = "zhao-2023.yaml"


def robots_here(folder: Path | None = None) -> list[str]:
    """Names of the files that describe a delta, in alphabetical order."""
    files = sorted((folder or Path()).glob("*.yaml"))[:MOST_LOOKED_AT]
    return [path.name for path in files if _describes_a_delta(path)]


def proposed() -> list[str]:
    """Robot files to propose: one's own where there are some, else the example."""
    return robots_here() or [EXAMPLE]


def _describes_a_delta(path: Path) -> bool:
    try:
        data = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, yaml.YAMLError):
        return False
    return isinstance(data, dict) and data.get("kind") == "delta"
