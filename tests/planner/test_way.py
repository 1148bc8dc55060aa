"""Legs, arcs and corners: how far the way stays from what was drawn, where it stands, how fast."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from deltactl.firmware_py.job_file import JobFile
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.paths.corner import from_polyline, turns_rad
from deltactl.firmware_py.paths.courses import Courses
from deltactl.firmware_py.paths.legs import Legs
from deltactl.firmware_py.paths.way import way
from deltactl.firmware_py.planner.plan import make_plan
from deltactl.firmware_py.robot_file import load_robot
from deltactl.models.inverse_kinematics import GeometricInverse
from deltactl.models.robot import FloatArray

ROBOT = load_robot(CONFIG_FOLDER / "zhao-2023.yaml")
SPACING_M = 0.0005
coordinate = st.floats(-0.1, 0.1).map(lambda value: round(value, 4))
points = st.lists(st.tuples(coordinate, coordinate, coordinate), min_size=3, max_size=7)


@given(points, st.floats(0.0, 0.02))
@settings(max_examples=50, deadline=None)
def test_corners_are_cut_by_no_more_than_is_allowed(drawn, corner_m: float) -> None:
    corners = np.array(drawn)
    if (np.linalg.norm(np.diff(corners, axis=0), axis=1) < 1e-3).any():
        return
    path = way(corners[0], Legs.of({"to_m": point} for point in corners[1:]), corner_m, SPACING_M)
    assert from_polyline(path.targets, corners).max() <= corner_m + 1e-9
    assert (path.targets[0] == corners[0]).all()
    assert (path.targets[-1] == corners[-1]).all()
    hops = np.linalg.norm(np.diff(path.targets, axis=0), axis=1)
    assert hops.max() <= SPACING_M * 1.001
    for corner in corners[1:-1]:  # and passed no further away than that
        assert np.linalg.norm(path.targets - corner, axis=1).min() <= corner_m + SPACING_M
    assert len(path.dwell_s) == len(path.rest) == len(path.targets)
    assert path.speed_mps is not None
    assert len(path.speed_mps) == len(path.targets)


def test_it_stands_at_corners_only_where_they_may_not_be_cut() -> None:
    square = [np.array([x, y, 0.0]) for x, y in ((0.1, 0), (0.1, 0.1), (0, 0.1), (0, 0))]
    start = np.zeros(3)
    assert way(start, Legs.of({"to_m": p} for p in square), 0.0, SPACING_M).rest.sum() == 5
    assert way(start, Legs.of({"to_m": p} for p in square), 0.001, SPACING_M).rest.sum() == 2
    waits = Legs.of({"to_m": p, "dwell_s": 0.5 * (n == 1)} for n, p in enumerate(square))
    path = way(start, waits, 0.001, SPACING_M)
    assert path.rest.sum() == 3
    assert path.dwell_s.sum() == 0.5
    assert (path.targets[path.dwell_s > 0] == square[1]).all()


def test_straight_on_is_no_corner() -> None:
    legs = Legs.of({"to_m": (x, 0.0, 0.0)} for x in (0.01, 0.02, 0.03))
    assert way(np.zeros(3), legs, 0.0, SPACING_M).rest.sum() == 2


@pytest.mark.parametrize("turns", [1.0, 0.25, -0.75])
def test_an_arc_keeps_its_radius(turns: float) -> None:
    angle = 2 * math.pi * turns
    end = np.array([0.05 * math.cos(angle), 0.05 * math.sin(angle), 0.01])
    leg = {"to_m": end, "centre_m": (0.0, 0.0), "clockwise": turns < 0.0}
    path = way(np.array([0.05, 0.0, 0.0]), Legs.of([leg]), 0.0, SPACING_M)
    assert np.hypot(*path.targets[:, :2].T) == pytest.approx(0.05, abs=1e-12)
    swept = np.unwrap(np.arctan2(path.targets[:, 1], path.targets[:, 0]))
    assert swept[-1] - swept[0] == pytest.approx(angle, abs=1e-9)
    assert (np.diff(path.targets[:, 2]) >= 0).all()


def at_parts(courses: Courses, leg: int, part: FloatArray) -> FloatArray:
    return courses.at(np.full(len(part), leg), part * courses.length_m[leg])


angle = st.floats(-math.pi, math.pi)


@pytest.mark.study
@example(0.0, -3.0, 0.09375, 0.015625, True)  # by 0.03 mm more, with 33 samples of the curve
@given(angle, angle, st.floats(0.02, 0.1), st.floats(0.001, 0.02), st.booleans())
@settings(max_examples=15, deadline=None)
def test_corners_of_arcs_are_cut_by_no_more_than_is_allowed(
    first: float, swing: float, radius_m: float, corner_m: float, on_to_an_arc: bool
) -> None:
    if abs(swing) < 0.3:
        return
    at = [radius_m * np.array([math.cos(a), math.sin(a), 0.0]) for a in (first, first + swing)]
    arc = {"to_m": at[1], "centre_m": (0.0, 0.0), "clockwise": swing < 0.0}
    start = np.array([0.15, -0.02, 0.03])
    rows = [{"to_m": at[0]}, arc, {"to_m": (-0.15, 0.1, -0.01)}]
    if on_to_an_arc:  # the other way round about another axis: arc meets arc
        rows.insert(2, {"to_m": at[1], "centre_m": (0.2, 0.0), "clockwise": True})
    legs = Legs.of(rows)
    path = way(start, legs, corner_m, SPACING_M)
    courses = Courses(start, legs)
    drawn = np.concatenate(
        [at_parts(courses, number, np.linspace(0.0, 1.0, 800)) for number in range(len(legs))]
    )
    assert from_polyline(path.targets, drawn).max() <= corner_m + 2e-5  # of the samples
    assert np.linalg.norm(np.diff(path.targets, axis=0), axis=1).max() <= SPACING_M * 1.02
    for end_m in legs.to_m[:-1]:
        assert np.linalg.norm(path.targets - end_m, axis=1).min() <= corner_m + SPACING_M
    assert path.rest.sum() == 2


@given(points)
@settings(max_examples=25, deadline=None)
def test_a_spline_passes_every_point_and_never_turns_sharply(drawn) -> None:
    corners = np.array(drawn)
    hops = np.diff(corners, axis=0)
    sizes = np.linalg.norm(hops, axis=1)
    if (sizes < 1e-3).any():
        return
    if (np.cross(hops[:-1], hops[1:]) ** 2).sum(axis=1).min() < 1e-8 * sizes.min() ** 4:
        return  # straight back: the arms stand there
    legs = Legs.of({"to_m": point, "spline": True} for point in corners[1:])
    path = way(corners[0], legs, 0.0, SPACING_M)
    for corner in corners:
        assert (np.linalg.norm(path.targets - corner, axis=1) == 0.0).any()
    assert path.rest.sum() == 2
    assert turns_rad(Courses(corners[0], legs)) == pytest.approx(0.0, abs=1e-4)


def test_a_spline_through_points_of_a_circle_is_nearly_one() -> None:
    angles = np.linspace(0.0, 2 * math.pi, 25)
    ring = 0.05 * np.stack([np.cos(angles), np.sin(angles), 0.0 * angles], axis=1)
    path = way(ring[0], Legs.of({"to_m": p, "spline": True} for p in ring[1:]), 0.0, SPACING_M)
    inside = path.targets[len(path.targets) // 4 : -len(path.targets) // 4]  # its ends are free
    assert np.linalg.norm(inside, axis=1) == pytest.approx(0.05, abs=2e-6)


def job(**path) -> JobFile:
    return JobFile.model_validate_json(json.dumps({
        "name": "way", "robot": "zhao-2023.yaml",
        "path": {"shape": "way", "start_m": [0.05, 0.05, -0.45], **path},
        "timing": {"mode": "accelerated", "speed_mps": 0.2},
        "inverse_kinematics": {"kind": "geometry"},
    }))  # fmt: skip


def seconds(made: JobFile) -> float:
    plan = make_plan(made, ROBOT, GeometricInverse(ROBOT.geometry))
    return plan.first.schedule.duration_ns * 1e-9


def test_a_slow_leg_is_slow_and_a_dwell_waits() -> None:
    legs = [{"to_m": [-0.05, 0.05, -0.45]}, {"to_m": [-0.05, -0.05, -0.45]}]
    usual = seconds(job(legs=legs))
    slow = seconds(job(legs=[legs[0], legs[1] | {"speed_mps": 0.01}]))
    waits = seconds(job(legs=[legs[0] | {"dwell_s": 1.5}, legs[1]]))
    assert slow == pytest.approx(usual + 0.1 / 0.01 - 0.1 / 0.2, abs=0.5)
    assert waits == pytest.approx(usual + 1.5, abs=1e-6)


def test_cutting_corners_saves_time() -> None:
    legs = [{"to_m": [x, y, -0.45]} for x, y in ((-0.05, 0.05), (-0.05, -0.05), (0.05, -0.05))]
    assert seconds(job(legs=legs, corner_m=0.005)) < seconds(job(legs=legs)) - 0.1


@pytest.mark.parametrize(
    ("legs", "says"),
    [
        ([{"to_m": [0, 0, -0.45], "centre_m": [0.03, 0.0]}], "equally far from both ends"),
        ([{"to_m": [0, 0, -0.45], "speed_mps": 0}], "greater than or equal"),
        ([], "at least 1 item"),
        ([{"to_m": [0, 0, -0.45], "centre_m": [0.0, 0.0], "spline": True}], "not both"),
        ([{"to_m": [0.05, 0.05, -0.45], "spline": True}], "end elsewhere"),
    ],
)
def test_a_wrong_leg_is_refused(legs, says: str) -> None:
    with pytest.raises(ValueError, match=says):
        job(legs=legs)
