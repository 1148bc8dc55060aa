"""The way to a path's start: within limits, and round singular poses."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.paths import reach
from deltactl.firmware_py.planner.approach import approach, find_way
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.errors import UnreachablePoint
from deltactl.models.linkage import Linkage

angle = st.floats(-20.0, 110.0)
pose = st.tuples(angle, angle, angle)


@settings(max_examples=60, deadline=None)
@given(start=pose, goal=pose)
def test_a_way_between_good_poses_keeps_the_margin(zhao, start, goal):
    linkage, ends = Linkage.of(zhao.geometry), np.deg2rad([start, goal])
    if reach.poses(linkage, ends).margin.min() < 0.05:
        return
    way = find_way(zhao, *ends)
    assert (way[0] == ends[0]).all()
    assert (way[-1] == ends[1]).all()
    assert reach.moves(linkage, way).margin.min() >= 0.05
    assert np.rad2deg(way).min() >= -20.0 - 1e-9
    assert np.rad2deg(way).max() <= 110.0 + 1e-9


@settings(max_examples=30, deadline=None)
@given(goal=st.tuples(*[st.floats(25.0, 80.0)] * 3), leave=st.booleans())
def test_from_and_to_the_upper_stops_arm_after_arm(zhao, goal, leave):
    """All arms at -20 degrees are beyond their serial singularities, see approach.py."""
    stops, goal_rad = np.deg2rad([-20.0, -20.0, -20.0]), np.deg2rad(goal)
    linkage = Linkage.of(zhao.geometry)
    assert reach.poses(linkage, stops[None]).serial[0] < 0.0
    way = find_way(zhao, stops, goal_rad) if leave else find_way(zhao, goal_rad, stops)
    assert reach.moves(linkage, way).parallel.min() > 0.4


def test_the_straight_way_from_the_upper_stops_would_lead_through_the_flat_pose(zhao):
    straight = np.deg2rad([[-20.0] * 3, [40.0] * 3])
    assert reach.moves(Linkage.of(zhao.geometry), straight).parallel[0] < 0.05


def test_speed_is_that_of_the_approach(zhao):
    schedule = approach(zhao, np.deg2rad([30.0] * 3), np.deg2rad([30.0, 90.0, 50.0]))
    speed_radps = schedule.peak_rate_hz * zhao.drive.rad_per_step
    assert speed_radps.max() == pytest.approx(zhao.limits.approach_speed_radps)
    # 60 degrees at 0.5 rad/s, and a ramp of 0.5 / (0.8 * 20) s.
    assert schedule.duration_ns * 1e-9 == pytest.approx(np.deg2rad(60) / 0.5 + 0.03125)


def test_a_start_that_cannot_be_assembled_is_told():
    printed = load_robot(CONFIG_FOLDER / "zhao-2023-as-printed.yaml")
    with pytest.raises(UnreachablePoint, match=r"arms are at .* cannot be assembled"):
        find_way(printed, np.deg2rad([-20.0] * 3), np.deg2rad([100.0] * 3))


def test_home_outside_the_box_may_be_left(limited):
    robot = limited(box_m=((-0.1, 0.1), (-0.1, 0.1), (-0.5, -0.4)))
    home = np.deg2rad(robot.homing.angle_deg)
    assert reach.poses(Linkage.of(robot.geometry), home[None]).position_m[0, 2] > -0.4
    find_way(robot, home, np.deg2rad([50.0] * 3))


def test_a_way_out_of_the_box_is_not_taken(limited):
    """Between two poses 0.1 m aside the platform sinks below where it began."""
    robot = limited(box_m=((-0.2, 0.2), (-0.2, 0.2), (-0.62, -0.3)))
    start, goal = np.deg2rad([60.0, 60.0, 60.0]), np.deg2rad([70.0, 70.0, 40.0])
    seen = reach.moves(Linkage.of(robot.geometry), find_way(robot, start, goal))
    assert seen.low_m[:, 2].min() >= -0.62
    tight = limited(box_m=((-0.2, 0.2), (-0.001, 0.001), (-0.7, -0.3)))
    with pytest.raises(UnreachablePoint, match="no way of the arms from"):
        find_way(tight, start, goal)
