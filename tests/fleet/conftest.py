"""A small fleet of geared axes, simulated by the benchmark's own code."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.costs.fleet_throughput import make_fleet
from tests.charts.conftest import chromium, open_report

__all__ = ["chromium", "open_report"]


@pytest.fixture(scope="session")
def fleet_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two robots whose play grows (of three that the benchmark makes), seven recordings each."""
    folder = tmp_path_factory.mktemp("fleet")
    make_fleet(folder, robots=2, recordings=7)
    return folder
