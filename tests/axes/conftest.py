"""The rigs of this folder, imported by file: tests have no packages."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

NAME = "axis_rigs"


@pytest.fixture(scope="session")
def rigs() -> ModuleType:
    """The module with the independent simulators."""
    path = Path(__file__).with_name(f"{NAME}.py")
    spec = importlib.util.spec_from_file_location(NAME, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[NAME] = module
    spec.loader.exec_module(module)
    return module
