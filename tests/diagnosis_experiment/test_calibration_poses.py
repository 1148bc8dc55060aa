"""Poses to measure tell more of an arm than random ones, and lie within its limits."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from benchmarks.proofs.measured_arm import Hidden, place, urdf_text
from deltactl.cli.main import app

pytest.importorskip("mujoco")
COUNT, STEP = 24, 1e-5


def _information(poses: np.ndarray) -> float:
    """Logarithm of the determinant, by differences of the arm's own places: zeros and lengths that
    base and reflector do not make up for.
    """
    hidden = Hidden()
    columns = []
    for joint in range(1, 5):
        off = np.eye(6)[joint] * STEP
        columns.append([(place(q + off, hidden)[0] - place(q, hidden)[0]) for q in poses])
    for joint, axis in ((1, 0), (2, 2), (3, 2), (4, 2)):
        longer = Hidden()
        longer.off[joint, axis] = STEP
        columns.append([(place(q, longer)[0] - place(q, hidden)[0]) for q in poses])
    told = np.array(columns).reshape(len(columns), -1).T / STEP
    where = np.array([place(q, hidden)[0] for q in poses])
    turned = [np.cross(axis, where).ravel() for axis in np.eye(3)]
    moved = [np.tile(axis, len(poses)) for axis in np.eye(3)]
    free = np.stack([*turned, *moved], axis=1)
    told -= free @ np.linalg.lstsq(free, told, rcond=None)[0]
    return float(np.linalg.slogdet(told.T @ told)[1])


@pytest.mark.study
def test_poses_to_measure_tell_more_than_random_ones(tmp_path: Path) -> None:
    model, robot = tmp_path / "arm.urdf", tmp_path / "arm.yaml"
    model.write_text(urdf_text())
    words = ["init", "chain", str(robot), "--model", str(model), "--poses", str(COUNT)]
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 0, done.output
    poses = np.loadtxt(tmp_path / "arm-poses.csv", delimiter=",", skiprows=1)
    assert poses.shape == (COUNT, 6)
    assert np.abs(poses).max() <= 3.2
    assert len(np.unique(poses, axis=0)) == COUNT
    rng = np.random.default_rng(2)
    drawn = [_information(rng.uniform(-3.0, 3.0, (COUNT, 6))) for _ in range(20)]
    assert _information(poses) > max(drawn)


def test_poses_that_are_there_are_kept(tmp_path: Path) -> None:
    model, robot = tmp_path / "arm.urdf", tmp_path / "arm.yaml"
    model.write_text(urdf_text())
    kept = tmp_path / "arm-poses.csv"
    kept.write_text("mine")
    words = ["init", "chain", str(robot), "--model", str(model), "--poses", str(COUNT)]
    done = CliRunner().invoke(app, words)
    assert done.exit_code != 0
    assert kept.read_text() == "mine"
    assert not robot.exists()
