"""Small sets of samples of the Zhao robot."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from deltactl.models.linkage import Linkage, forward
from deltactl.models.network.metadata import fingerprint
from deltactl.models.robot import DeltaRobot, FloatArray
from deltactl.models.robot_files import load_delta
from deltactl.models.training.dataset import DataSettings, DataSetWriter
from deltactl.models.training.samples import random_poses

CONFIG = Path(__file__).resolve().parents[2] / "config"
SHORT_ANGLES_DEG = (0.0, 70.0)

MakeData = Callable[..., Path]


@pytest.fixture(scope="session")
def zhao_robot() -> DeltaRobot:
    return load_delta(CONFIG / "zhao-2023.yaml")


@pytest.fixture(scope="session")
def exact(zhao_robot: DeltaRobot) -> tuple[FloatArray, FloatArray]:
    """400 exact samples, well away from the edges: positions and angles."""
    return random_poses(Linkage.of(zhao_robot.geometry), 400, SHORT_ANGLES_DEG, seed=3)


@pytest.fixture
def make_data(zhao_robot: DeltaRobot, tmp_path: Path) -> MakeData:
    """Writes a data set of a robot that is a little wrong, and gives its folder."""

    def make(count: int = 120, noise_m: float = 1e-3, spoil: str = "", name: str = "data") -> Path:
        robot = zhao_robot
        assert robot.drive is not None
        assert robot.sensors is not None
        settings = DataSettings(
            robot="another-robot" if spoil == "robot" else robot.name,
            fingerprint=fingerprint(robot.geometry),
            geometry=robot.geometry,
            drive=robot.drive,
            sensors=robot.sensors,
            machine="simulated",
            seed=1,
            angle_deg=SHORT_ANGLES_DEG,
            t_pwm_s=0.006,
            dwell_s=0.1,
        )
        _, angles_rad = random_poses(Linkage.of(robot.geometry), count, SHORT_ANGLES_DEG, seed=5)
        counts = np.rint(angles_rad / robot.drive.rad_per_step).astype(np.int64)
        true = Linkage.of(robot.geometry.model_copy(update={"home_offset_deg": (3.0, 2.0, 4.0)}))
        position_m = forward(true, counts * robot.drive.rad_per_step).position_m
        position_m = position_m + np.random.default_rng(2).normal(0.0, noise_m, position_m.shape)
        if spoil == "nan":
            position_m[7, 1] = np.nan
        if spoil == "constant":
            position_m[:, 2] = -0.4
        with DataSetWriter(tmp_path / name, settings) as writer:
            writer.append(zip(counts, position_m, strict=True))
        return tmp_path / name

    return make
