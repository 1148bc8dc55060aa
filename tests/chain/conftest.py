"""A robot and a motion for the tests of the chain."""

from __future__ import annotations

import numpy as np
import pytest

from models.robot import DeltaRobot


@pytest.fixture
def robot() -> DeltaRobot:
    return DeltaRobot.model_validate(
        {
            "kind": "delta",
            "name": "test",
            "geometry": {
                "base_radius_m": 0.325,
                "platform_radius_m": 0.075,
                "upper_arm_m": 0.25,
                "forearm_m": 0.5,
            },
            "masses": {"upper_arm_kg": 0.205, "forearm_kg": 0.153, "platform_kg": 0.653},
            "drive": {"microsteps_per_rev": 1600, "gear_ratio": 10},
            "sensors": {
                "x": {"offset_m": 0.6, "axis": (1, 0, 0)},
                "y": {"offset_m": 0.6, "axis": (0, 1, 0)},
                "z": {"offset_m": 0.9, "axis": (0, 0, 1)},
            },
        }
    )


@pytest.fixture
def motion() -> tuple[np.ndarray, np.ndarray]:
    """Times [s] at 50 Hz and whole microsteps of a smooth motion, (300,) and (300, 3)."""
    t_s = 0.02 * np.arange(300)
    phase = np.array([0.0, 1.0, 2.5])
    counts = np.round(1600 + 900 * np.sin(1.3 * t_s[:, None] + phase))
    return t_s, counts
