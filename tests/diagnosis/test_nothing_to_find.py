"""Healthy deltas, whatever they are measured by, and recordings that were computed: no error."""

from __future__ import annotations

import numpy as np
import pytest

from deltactl.diagnosis.api import diagnose_recordings
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.models.chain import Chain, Commands
from deltactl.models.linkage import Linkage, forward
from deltactl.models.robot import DeltaRobot, FloatArray
from deltactl.models.robot_files import load_robot_model
from deltactl.recording.tables.flat import FlatRecording

pytestmark = pytest.mark.study

ROWS = 600
T_S = np.arange(ROWS) * 0.02


@pytest.fixture(scope="module")
def zhao() -> DeltaRobot:
    robot = load_robot_model(CONFIG_FOLDER / "zhao-2023.yaml")
    assert isinstance(robot, DeltaRobot)
    return robot


def angles_rad(alike: bool) -> FloatArray:
    """Arms that swing, (n, 3): all alike, or each in its own way."""
    phase = np.zeros(3) if alike else np.arange(3.0)
    angles: FloatArray = 0.8 + 0.2 * np.sin(2.1 * T_S[:, None] + phase)
    return angles


def recorded(robot: DeltaRobot, kind: str, noise: float, alike: bool) -> FlatRecording:
    """Commands, and readings of this kind."""
    commanded = angles_rad(alike)
    rng = np.random.default_rng(4)
    if kind == "range":
        read = Chain(robot).simulate(Commands.of_angles(T_S, commanded)).ranges
    elif kind == "pos":
        read = forward(Linkage.of(robot.geometry), commanded).position_m
    else:
        read = commanded
    read = read + noise * rng.standard_normal(read.shape)
    numbered = kind == "theta"
    columns = {f"command_{arm + 1}": commanded[:, arm] for arm in range(3)} | {
        f"{kind}_{arm + 1 if numbered else 'xyz'[arm]}": read[:, arm] for arm in range(3)
    }
    return FlatRecording(T_S, columns, {}, "healthy")


@pytest.mark.parametrize("alike", [False, True])
@pytest.mark.parametrize("noise", [0.0, 1e-4])
@pytest.mark.parametrize("kind", ["theta", "pos", "range"])
def test_nothing_is_missing(zhao: DeltaRobot, kind: str, noise: float, alike: bool) -> None:
    """Angles have no nuisances to fit; a platform that moves up and down reads 0 in x and y."""
    answer = diagnose_recordings(zhao, [recorded(zhao, kind, noise, alike)], [])
    assert answer.verdict == "nothing_missing"
    assert not answer.findings
