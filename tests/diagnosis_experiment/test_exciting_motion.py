"""A motion to record stays within the limits of the joints, and tells more than others drawn."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

from deltactl.cli.main import app
from deltactl.diagnosis.experiment.exciting_motion import (
    OF_TOP_SPEED,
    RATE_HZ,
    Series,
    drawn_blindly,
    exciting_motion,
    information,
)
from deltactl.models.rigid_chain import RigidChain
from deltactl.models.robot import ChainRobot
from deltactl.models.robot_files import load_with_effects

pytest.importorskip("mujoco")
TOP = (1.5, 0.8)


def _urdf() -> str:
    """Two joints: one on a level axis behind one on an upright axis."""
    links = ['<robot name="two"><link name="base"/>']
    parents, axes = ("base", "upper"), ("0 0 1", "0 1 0")
    for parent, link, axis, top in zip(parents, ("upper", "lower"), axes, TOP, strict=True):
        links.append(
            f'<joint name="j_{link}" type="revolute"><parent link="{parent}"/>'
            f'<child link="{link}"/><origin xyz="0.1 0 0.2"/><axis xyz="{axis}"/>'
            f'<limit lower="-1.0" upper="2.0" effort="9" velocity="{top}"/></joint>'
            f'<link name="{link}"><inertial><origin xyz="0.2 0 0.05"/><mass value="3"/>'
            '<inertia ixx="0.02" iyy="0.03" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        )
    return "".join([*links, "</robot>"])


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    (tmp_path / "arm.urdf").write_text(_urdf())
    words = ["init", "chain", str(tmp_path / "arm.yaml"), "--model", str(tmp_path / "arm.urdf")]
    done = CliRunner().invoke(app, [*words, "--motion"])
    assert done.exit_code == 0, done.output
    return tmp_path / "arm.yaml"


@pytest.mark.study
def test_a_motion_to_record_begins_at_rest_and_stays_within_limits(robot: Path) -> None:
    t_s, *at = np.loadtxt(robot.with_name("arm-motion.csv"), delimiter=",", skiprows=1).T
    speed = np.gradient(np.array(at), t_s, axis=1)
    change = np.gradient(speed, t_s, axis=1)
    assert np.min(at) >= -1.0
    assert np.max(at) <= 2.0
    fastest = np.abs(speed).max(axis=1)
    assert (fastest <= OF_TOP_SPEED * np.array(TOP) * 1.01).all()
    assert (fastest > 0.2 * np.array(TOP)).all()
    assert np.abs(speed[:, [0, -1]]).max() < 0.02
    assert np.abs(change[:, 0]).max() < 0.1 * np.abs(change).max()


@pytest.mark.study
def test_its_job_says_the_same_as_its_table(robot: Path) -> None:
    job = yaml.safe_load(robot.with_name("arm-motion.yaml").read_text())
    path = job["path"]
    series = Series(*(np.array(path[name]) for name in ("middle", "sine", "cosine")))
    rows = np.loadtxt(robot.with_name("arm-motion.csv"), delimiter=",", skiprows=1)
    assert series.at(rows[:, 0])[0] == pytest.approx(rows[:, 1:], abs=2e-5)
    assert len(rows) == job["repeats"] * path["period_s"] * RATE_HZ + 1


@pytest.mark.study
def test_it_tells_more_than_motions_that_were_drawn_blindly(robot: Path) -> None:
    described = load_with_effects(robot)
    assert isinstance(described, ChainRobot)
    chain = RigidChain(robot.with_name("arm.urdf"), described.joints)
    best = information(described, chain, exciting_motion(described, chain))
    rng = np.random.default_rng(7)
    blind = [information(described, chain, drawn_blindly(rng, chain)) for _ in range(8)]
    assert best > np.max(blind)


def test_a_motion_that_is_there_is_kept(tmp_path: Path) -> None:
    model, kept = tmp_path / "arm.urdf", tmp_path / "arm-motion.csv"
    model.write_text(_urdf())
    kept.write_text("mine")
    words = ["init", "chain", str(tmp_path / "arm.yaml"), "--model", str(model), "--motion"]
    assert CliRunner().invoke(app, words).exit_code != 0
    assert kept.read_text() == "mine"
