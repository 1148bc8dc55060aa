"""The survey: random, repeatable, and only through poses that can be had."""

from __future__ import annotations

import numpy as np
import pytest

from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.paths import reach
from deltactl.firmware_py.paths.survey import LEAST_GAIN, gain, held, off_singular, survey
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.errors import UnreachablePoint
from deltactl.models.linkage import Linkage, neighbours

RANGE_DEG = (-20.0, 110.0)


@pytest.fixture(scope="module")
def linkage(zhao):
    return Linkage.of(zhao.geometry)


def test_every_pose_and_every_way_between_keeps_the_margin(linkage):
    path = survey(off_singular(linkage, 0.05), 600, RANGE_DEG, 0.1, 3)
    assert reach.poses(linkage, path.targets).margin.min() >= 0.05
    assert reach.moves(linkage, path.targets).margin.min() >= 0.05
    assert path.rest.all()
    assert (path.dwell_s == 0.1).all()


@pytest.mark.study
def test_machines_off_the_file_are_held_all_along(linkage):
    for seed in (1, 2):
        angles = survey(held(linkage, 0.05), 200, RANGE_DEG, 0.0, seed).targets
        for machine in (linkage, *neighbours(linkage)):
            least = reach.least(lambda poses, machine=machine: gain(machine, poses), angles)
            assert least.min() >= LEAST_GAIN
        assert reach.moves(linkage, angles).margin.min() >= 0.05


def test_some_triples_had_to_be_skipped(linkage):
    """About 2.6 % of uniform triples come nearer than 0.05, 1.8 % lie beyond."""
    drawn = np.deg2rad(np.random.default_rng(3).uniform(*RANGE_DEG, (20_000, 3)))
    poses = reach.poses(linkage, drawn)
    assert 0.015 < (poses.serial < 0.0).mean() < 0.021
    assert 0.022 < (poses.margin < 0.05).mean() < 0.031


@pytest.mark.study
def test_same_seed_same_angles_and_a_larger_count_adds_to_them(linkage):
    spare = held(linkage, 0.05)
    few = survey(spare, 100, RANGE_DEG, 0.0, 7)
    many = survey(spare, 900, RANGE_DEG, 0.0, 7)
    other = survey(spare, 100, RANGE_DEG, 0.0, 8)
    assert (few.targets == many.targets[:100]).all()
    assert (few.targets != other.targets).all()


def test_angles_are_spread_over_the_whole_range(linkage):
    degrees = np.rad2deg(survey(off_singular(linkage, 0.05), 3000, RANGE_DEG, 0.0, 1).targets)
    counts = np.array([np.histogram(arm, bins=10, range=RANGE_DEG)[0] for arm in degrees.T])
    # Uniform but for the corner that is cut off at low angles of all arms.
    assert (counts > 220).all()
    assert (counts < 370).all()


def test_lengths_that_cannot_be_assembled_are_refused():
    printed = load_robot(CONFIG_FOLDER / "zhao-2023-as-printed.yaml")
    with pytest.raises(UnreachablePoint, match="check the robot's lengths") as error:
        survey(off_singular(Linkage.of(printed.geometry), 0.05), 100, RANGE_DEG, 0.0, 1)
    assert "\n" not in str(error.value)
