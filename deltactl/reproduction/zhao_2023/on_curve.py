"""Data sets of a trajectory itself: counts and readings while the robot follows it once."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from deltactl.firmware_py.collecting.settings import settings_of
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.models.training.dataset import SAMPLES, DataSet, load_dataset
from deltactl.models.training.dataset_writer import DataSetWriter
from deltactl.reproduction.zhao_2023.as_built import AsBuiltFile
from deltactl.reproduction.zhao_2023.curves import TRAINED_T_PWM_S
from deltactl.reproduction.zhao_2023.tracking import Track


def collect_on_curve(
    folder: Path, robot: RobotFile, built: AsBuiltFile, curve: str, track: Track
) -> DataSet:
    """Single readings at 50 Hz in motion: there is no time to stand still. Writes it anew."""
    settings = settings_of(
        robot, "as-built", 0, built.mark, f"{curve}, once round", TRAINED_T_PWM_S
    )
    seen = np.isfinite(track.seen_m).all(axis=1)
    (folder / SAMPLES).unlink(missing_ok=True)
    with DataSetWriter(folder, settings) as writer:
        writer.append(zip(track.seen_counts[seen], track.seen_m[seen], strict=True))
    return load_dataset(folder)
