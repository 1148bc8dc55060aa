"""A robot and a motion for the tests of the chain."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from deltactl.models.robot import DeltaRobot
from deltactl.models.robot_files import load_delta

ZHAO = Path(__file__).parents[2] / "config" / "zhao-2023.yaml"


@pytest.fixture
def robot() -> DeltaRobot:
    return load_delta(ZHAO)


@pytest.fixture
def motion() -> tuple[np.ndarray, np.ndarray]:
    """Times [s] at 50 Hz and whole microsteps of a smooth motion, (300,) and (300, 3)."""
    t_s = 0.02 * np.arange(300)
    phase = np.array([0.0, 1.0, 2.5])
    counts = np.round(1600 + 900 * np.sin(1.3 * t_s[:, None] + phase))
    return t_s, counts
