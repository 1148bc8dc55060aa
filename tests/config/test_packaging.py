"""What a wheel carries: every file of a package that is not code is named in pyproject.toml."""

from __future__ import annotations

import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
SETUPTOOLS = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]
FOLDERS = [name.rstrip("*") for name in SETUPTOOLS["packages"]["find"]["include"]]
DATA = SETUPTOOLS["package-data"]


def carried() -> set[Path]:
    """Files that the patterns of package-data name."""
    return {
        path
        for package, patterns in DATA.items()
        for pattern in patterns
        for path in (ROOT / package.replace(".", "/")).glob(pattern)
        if path.is_file()
    }


def test_every_data_file_is_carried() -> None:
    there = {
        path
        for folder in FOLDERS
        for path in (ROOT / folder).rglob("*")
        if path.is_file() and path.suffix != ".py" and path.parent.name != "__pycache__"
    }
    assert ROOT / "config" / "heart.yaml" in there
    assert there <= carried()
