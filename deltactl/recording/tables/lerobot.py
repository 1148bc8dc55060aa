"""LeRobot data sets: a folder of Parquet files, with what their columns are in `meta/info.json`.

Versions 2 (a file an episode) and 3 (several episodes a file):
https://huggingface.co/docs/lerobot/lerobot-dataset-v3
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from deltactl.foundation.errors import RecordingError

INFO = Path("meta", "info.json")
JOINTS = ("action", "observation.state")
"""Features with one value a joint: what was asked of them, and what came of it."""
FOLDERS_UP = 3
"""From a file of a data set to its folder: data/chunk-000/file-000.parquet."""


def is_data_set(path: Path) -> bool:
    """Whether a path is the folder of a LeRobot data set."""
    return (path / INFO).is_file()


def files_of(path: Path) -> list[Path]:
    """The tables of a data set, in the order of their episodes; raises RecordingError without any.

    Files whose data were not fetched (Git LFS) are refused where they are read.
    """
    files = sorted((path / "data").glob("*/*.parquet"))
    if not files:
        raise RecordingError(
            f"{path}: is a LeRobot data set without data/chunk-*/*.parquet; fetch those files too"
        )
    return files


def names_of(path: Path) -> dict[str, list[str]]:
    """Names of the joints by feature, of a data set or of a file in one; empty where none is said.

    Raises RecordingError where meta/info.json is not what it should be.
    """
    folders = [path, *path.resolve().parents[:FOLDERS_UP]]
    folder = next((one for one in folders if is_data_set(one)), None)
    if folder is None:
        return {}
    try:
        features = json.loads((folder / INFO).read_text(encoding="utf-8"))["features"]
        found = {name: _listed(features[name].get("names")) for name in JOINTS if name in features}
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise RecordingError(f"{folder / INFO}: is not that of a LeRobot data set") from error
    return {name: names for name, names in found.items() if names}


def _listed(names: Any) -> list[str]:
    """Names of joints: a list, or a list under a heading such as `motors` (version 2.0)."""
    if isinstance(names, Mapping):
        names = next(iter(names.values()), [])
    plain = isinstance(names, list) and all(isinstance(one, str) for one in names)
    return names if plain and len(set(names)) == len(names) else []
