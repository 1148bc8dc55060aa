"""Curves that are given by many near points: driven at speed, and told where they are not."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.firmware_py.job_file import JobFile
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.paths.corner import from_polyline
from deltactl.firmware_py.paths.legs import Legs
from deltactl.firmware_py.paths.way import Lines, way
from deltactl.firmware_py.planner.plan import Plan, make_plan
from deltactl.firmware_py.planner.summary import slower
from deltactl.firmware_py.robot_file import load_robot
from deltactl.models.inverse_kinematics import GeometricInverse
from deltactl.models.robot import FloatArray

ROBOT = load_robot(CONFIG_FOLDER / "gripper-delta.yaml")
SPACING_M = 0.0005


def ring(count: int, decimals_mm: int, radius_mm: float = 50.0) -> FloatArray:
    """Points of a circle as a table holds them, (n, 3) [m]."""
    turn = np.linspace(0.0, 2.0 * np.pi, count)
    x, y = radius_mm * np.cos(turn), radius_mm * np.sin(turn)
    points = np.stack([x, y, np.full(count, -300.0)], axis=1)
    return np.round(points, decimals_mm) * 1e-3


def plan_of(points: FloatArray, corner_m: float, speed_mps: float = 0.05) -> Plan:
    legs = [{"to_m": point.tolist()} for point in points[1:]]
    path = {"shape": "way", "start_m": points[0].tolist(), "corner_m": corner_m, "legs": legs}
    job = JobFile.model_validate_json(json.dumps({
        "name": "dense", "robot": "gripper-delta.yaml", "path": path,
        "timing": {"mode": "accelerated", "speed_mps": speed_mps},
        "inverse_kinematics": {"kind": "geometry"},
    }))  # fmt: skip
    return make_plan(job, ROBOT, GeometricInverse(ROBOT.geometry))


@pytest.mark.parametrize(("count", "decimals"), [(501, 3), (3001, 3), (2001, 2), (200, 3)])
def test_a_dense_circle_is_driven_at_the_speed_asked_for(count: int, decimals: int) -> None:
    plan = plan_of(ring(count, decimals), 0.0005)
    lap, schedule = plan.first.lap, plan.first.schedule
    speed_mps = np.linalg.norm(np.diff(lap.position_m, axis=0), axis=1) / (
        np.diff(schedule.reached_ns) * 1e-9
    )
    assert speed_mps[20:-20].min() > 0.049
    assert schedule.duration_ns * 1e-9 < 1.05 * lap.length_m / 0.05
    assert from_polyline(lap.position_m, ring(count, decimals)).max() <= 0.0005
    assert slower([plan]) is None


def test_stops_that_keep_a_way_slow_are_told() -> None:
    found = slower([plan_of(ring(501, 3), 0.0)])
    assert found is not None
    assert "it stops at 499 corners, which corner_m rounds" in found.says()
    there_and_back = np.array([[0.05 * (n % 2), 0.002 * (n % 2), -0.3] for n in range(6)])
    assert slower([plan_of(there_and_back, 0.0, 0.02)]) is None


zigzag = st.lists(st.tuples(*[st.floats(-0.02, 0.02)] * 2), min_size=1, max_size=40)


@given(zigzag, st.floats(1e-5, 2e-3), st.sampled_from([1e-4, 1e-3, 0.01]))
@settings(max_examples=40, deadline=None)
def test_dense_ways_stay_within_the_corner_distance(offs, corner_m: float, hop_m: float) -> None:
    """Made of short hops that turn anywhere: legs made one, and cut, stay near to all of them."""
    steps = np.array([[hop_m, hop_m * 50 * x, hop_m * 50 * y] for x, y in offs])
    points = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
    path = way(points[0], Legs.of({"to_m": point} for point in points[1:]), corner_m, SPACING_M)
    assert from_polyline(path.targets, points).max() <= corner_m + 1e-9
    assert from_polyline(points, path.targets).max() <= corner_m + SPACING_M
    assert (path.targets[-1] == points[-1]).all()


def longest(points: FloatArray) -> int:
    return Lines(points, 0.1).longest(0, len(points) - 1)


def test_legs_that_turn_back_or_stray_are_no_line() -> None:
    line = np.zeros((50, 3))
    line[:, 0] = np.arange(50)
    assert longest(line) == 49
    back = line.copy()
    back[20, 0] = 17.5
    assert longest(back) < 20
    off = line.copy()
    off[30:, 1] = 5.0
    assert longest(off) <= 30
    assert longest(line[:2]) == 1


def test_a_dwell_on_a_dense_way_is_kept() -> None:
    legs = [{"to_m": (0.001 * n, 0.0, 0.0), "dwell_s": 0.5 * (n == 7)} for n in range(1, 20)]
    path = way(np.zeros(3), Legs.of(legs), 0.0005, SPACING_M)
    assert (path.targets[path.dwell_s > 0.0] == [[0.007, 0.0, 0.0]]).all()
    assert path.rest.sum() == 3
