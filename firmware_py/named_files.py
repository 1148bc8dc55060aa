"""Files that a user names: where they are sought, and which robot files may be proposed."""

from __future__ import annotations

import difflib
import os
from collections.abc import Sequence
from pathlib import Path

from deltactl.foundation.errors import ConfigError, MissingFile
from deltactl.foundation.process import PACKAGE

CONFIG_FOLDER = (PACKAGE / "config").resolve()
TRAINED_FOLDER = (PACKAGE / "models" / "trained").resolve()
"""Where they really lie: a working copy reaches both by links, which a daemon does not follow."""
SHOWN = 10
"""So many names of files are listed in a message."""
JOB_KEY, ROBOT_KEY = "robot", "kind"
"""Keys that a job and a robot file have, and the other has not."""
NO_YAML = frozenset(
    {".csv", ".tsv", ".txt", ".gz", ".parquet", ".mat", ".mcap", ".gcode", ".nc", ".ngc", ".g"}
)
"""Endings of recordings, tables of points and G-code."""
WRITES = "'deltactl init axis my-robot.yaml' writes one; for others, init delta, sensor or chain"
"""How a robot file comes about."""
NEEDED = {
    JOB_KEY: "a job (YAML) is needed here: 'deltactl convert {file} job.yaml --robot ROBOT.yaml'"
    " makes one of points in mm or of G-code, and 'deltactl inspect {file}' looks into a"
    " recording",
    ROBOT_KEY: f"a robot file (YAML) is needed here; {WRITES}",
}
"""What is said where a file of those is named for a job or a robot."""
LOOKED_INTO = 200
"""So many files are looked into for a proposal: a message must not wait for a folder full."""


def find(name: str, beside: Path | None = None, listing: bool = True, key: str = "") -> Path:
    """Where a named file is: as given, beside the file that names it, or in the project.

    The project's places are `config/` and, for networks, `models/trained/`. Raises
    MissingFile, which lists the files of that kind there are; without `listing` only
    those of the project, and with a key only those that have it at the left edge. With a
    key it raises ConfigError for a file that is there and by its name no YAML.
    """
    given = Path(name)
    no_yaml = bool(key) and given.suffix.lower() in NO_YAML
    folders = [Path() if beside is None else beside.parent, CONFIG_FOLDER, TRAINED_FOLDER]
    for folder in folders:
        if (folder / given).is_file():
            if no_yaml:
                raise ConfigError(f"{name}: {NEEDED[key].format(file=name)}")
            return folder / given
    suffix = "" if no_yaml or given.suffix == ".yml" else given.suffix  # both are YAML
    place = "here" if beside is None else f"beside {beside}"
    project = "models/trained" if given.suffix == ".tflite" else "config"
    instead = _instead(given.name, folders if listing else folders[1:], suffix or ".yaml", key)
    instead += f"; {WRITES}" if key == ROBOT_KEY else ""
    raise MissingFile(f"{name}: no such file {place} or in {project}; {instead}")


def _instead(name: str, folders: Sequence[Path], suffix: str, key: str) -> str:
    """The file of these folders that may be meant, or those that there are."""
    paths = [path for folder in folders for path in folder.glob(f"*{suffix}")]
    there = sorted({path.name for path in paths[:LOOKED_INTO] if not key or _has(path, key)})
    close = difflib.get_close_matches(name, there, n=1, cutoff=0.75)
    few = ", ".join(there[:SHOWN]) + (" and more" if len(there) > SHOWN else "")
    return f"did you mean '{close[0]}'?" if close else f"there are {few or 'none'}"


def named_beside(file: Path, writer: Path) -> str:
    """How a file that is written at `writer` names another, so that `find` finds it from there.

    One of the project by its name; others by the way from beside `writer`, so that both may be
    moved together, or in full where they have no folder in common.
    """
    folder, here = file.parent.resolve(), writer.parent.resolve()
    if folder != here and folder in (CONFIG_FOLDER, TRAINED_FOLDER):
        hidden = (here / file.name).is_file()
        return str(folder / file.name) if hidden else file.name
    if os.path.commonpath([folder, here]) == os.sep:
        return str(folder / file.name)
    return os.path.relpath(folder / file.name, here)


def _has(path: Path, key: str) -> bool:
    """Whether a YAML file has a key at its left edge; it need not be right otherwise."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError):
        return False
    return any(line.startswith(f"{key}:") for line in lines)


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
    import yaml  # a command that names its robot need not load it

    try:
        data = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, yaml.YAMLError):
        return False
    return isinstance(data, dict) and data.get("kind") == "delta"
