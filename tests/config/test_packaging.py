"""What a wheel carries: every file of a package that is not code is named in pyproject.toml."""

from __future__ import annotations

import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
SETUPTOOLS = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]
PACKAGE = ROOT / "deltactl"
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
    linked = [path for path in PACKAGE.iterdir() if path.is_symlink()]
    there = {
        folder / path.relative_to(folder.resolve())
        for folder in [PACKAGE, *linked]
        for path in folder.resolve().rglob("*")
        if path.is_file() and path.suffix != ".py" and path.parent.name != "__pycache__"
    }
    assert PACKAGE / "config" / "heart.yaml" in there
    assert there <= carried()
