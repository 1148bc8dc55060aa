"""What pyproject.toml says of the release."""

from __future__ import annotations

import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
VERSION = str(PROJECT["version"])
PYTHONS = [
    text.rpartition(" ")[2]
    for text in PROJECT["classifiers"]
    if text.startswith("Programming Language :: Python :: 3.")
]
EXTRAS = sorted({*PROJECT["optional-dependencies"]} - {"docs", "fuzz", "test"})
"""Parts of the program; the others are for those who work on it."""
