"""Robots and jobs the planner's tests plan with."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from deltactl.firmware_py.job_file import JobFile
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.robot_file import RobotFile, load_robot

MakeJob = Callable[..., JobFile]
MakeRobot = Callable[..., RobotFile]

CIRCLE = {"shape": "circle", "centre_m": [0, 0, -0.45], "radius_m": 0.05, "spacing_m": 0.001}
TOGETHER = {"mode": "together", "t_pwm_s": 0.002}


@pytest.fixture(scope="session")
def zhao() -> RobotFile:
    return load_robot(CONFIG_FOLDER / "zhao-2023.yaml")


@pytest.fixture(scope="session")
def micro() -> RobotFile:
    return load_robot(CONFIG_FOLDER / "uzunovic-2013.yaml")


@pytest.fixture(scope="session")
def job_of() -> MakeJob:
    """A job by its sections, stepping together round a small circle where nothing else is said."""

    def make(**sections: Any) -> JobFile:
        defaults = {
            "name": "test",
            "robot": "zhao-2023.yaml",
            "path": CIRCLE,
            "timing": TOGETHER,
            "inverse_kinematics": {"kind": "geometry"},
        }
        # Lists become tuples: the models are strict about them outside of files.
        return JobFile.model_validate(defaults | sections, strict=False)

    return make


@pytest.fixture(scope="session")
def limited(zhao: RobotFile) -> MakeRobot:
    """The Zhao robot with other limits."""

    def make(**limits: Any) -> RobotFile:
        changed = zhao.limits.model_copy(update=limits)
        return zhao.model_copy(update={"limits": changed})

    return make
