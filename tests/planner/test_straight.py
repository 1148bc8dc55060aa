"""Moves by hand: straight in space, no faster than asked, checked along the whole way."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.firmware_py.planner.plan import Plan, make_plan
from deltactl.firmware_py.planner.stream import MotionStream
from deltactl.foundation.errors import LimitExceeded
from deltactl.models.inverse_kinematics import GeometricInverse
from deltactl.models.linkage import Linkage, forward
from deltactl.models.robot import FloatArray

INSIDE = st.tuples(*[st.floats(-0.1, 0.1)] * 2, st.floats(-0.5, -0.4))


def plan_to(robot, job_of, to_m, speed_mps: float) -> Plan:
    job = job_of(
        path={"shape": "straight", "to_m": list(to_m)},
        timing={"mode": "accelerated", "speed_mps": speed_mps},
    )
    return make_plan(job, robot, GeometricInverse(robot.geometry))


def counts_at(robot, place_m) -> tuple[int, ...]:
    angles = GeometricInverse(robot.geometry).angles_rad(*place_m)
    return tuple(round(angle / robot.drive.rad_per_step) for angle in angles)


def driven(plan: Plan, counts) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Times, whole steps and places after each tick of the way."""
    chunks = [one.ticks for one in MotionStream(plan, counts)]
    t_s = np.concatenate([one.due_ns for one in chunks]) * 1e-9
    steps = np.concatenate([one.steps for one in chunks])
    made = np.array(counts) + np.cumsum(steps, axis=0)
    angles = made * plan.robot.drive.rad_per_step
    return t_s, made, forward(Linkage.of(plan.robot.geometry), angles).position_m


@settings(max_examples=25, deadline=None)
@given(start_m=INSIDE, goal_m=INSIDE, speed_mps=st.floats(0.001, 0.3))
def test_the_line_is_straight_and_no_faster_than_asked(zhao, job_of, start_m, goal_m, speed_mps):
    start = counts_at(zhao, start_m)
    far_m = float(np.linalg.norm(np.subtract(goal_m, start_m)))
    if far_m < 0.005:
        return
    plan = plan_to(zhao, job_of, goal_m, speed_mps)
    t_s, made, place_m = driven(plan, start)
    assert tuple(made[-1]) == counts_at(zhao, goal_m)
    along = np.subtract(goal_m, start_m) / far_m
    off = place_m - np.array(start_m)
    off -= np.outer(off @ along, along)
    a_step_m = 3 * plan.robot.drive.rad_per_step * 0.25
    assert np.linalg.norm(off, axis=1).max() < a_step_m
    for later in (len(t_s) // 4, len(t_s) // 2):  # whole steps shake what is looked at shortly
        if later:
            hops_m = np.linalg.norm(place_m[later:] - place_m[:-later], axis=1)
            took_s = t_s[later:] - t_s[:-later]
            assert (hops_m <= 1.005 * speed_mps * took_s + 2 * a_step_m).all()


def test_every_speed_takes_its_time(zhao, job_of) -> None:
    start = counts_at(zhao, (0.0, 0.0, -0.45))
    for speed_mps in (0.05, 0.005, 0.001):
        plan = plan_to(zhao, job_of, (0.04, 0.0, -0.45), speed_mps)
        took_s = MotionStream(plan, start).end_ns * 1e-9
        assert took_s == pytest.approx(0.04 / speed_mps, rel=0.04, abs=0.3)


def test_from_beyond_the_limits_the_arms_go_another_way_and_no_faster(zhao, job_of) -> None:
    """All arms at -20 degrees are beyond their serial singularities, see approach.py."""
    start = tuple(round(np.deg2rad(-20.0) / zhao.drive.rad_per_step) for _ in range(3))
    plan = plan_to(zhao, job_of, (0.0, 0.0, -0.45), 0.02)
    stream = MotionStream(plan, start)
    assert "no straight line leads out" in stream.otherwise
    t_s, _, place_m = driven(plan, start)
    hops_m = np.linalg.norm(place_m[100:] - place_m[:-100], axis=1)
    assert (hops_m <= 0.02 * (t_s[100:] - t_s[:-100]) + 1e-3).all()
    inside = MotionStream(plan, counts_at(zhao, (0.01, 0.0, -0.45)))
    assert inside.otherwise == ""


def test_a_line_that_leaves_the_limits_on_its_way_is_refused(limited, job_of) -> None:
    robot = limited(arm_deg=(10.5, 110.0))  # arm 1 is at 12 degrees at both ends, at 9 between
    plan = plan_to(robot, job_of, (0.15, 0.1, -0.4), 0.05)
    with pytest.raises(LimitExceeded, match=r"on the way to 150 100 -400 mm: arm 1 would be") as no:
        MotionStream(plan, counts_at(robot, (0.15, -0.1, -0.4)))
    assert no.value.at_point is not None
    assert no.value.at_point.on_the_way


@pytest.mark.parametrize("timing", [{"mode": "together", "t_pwm_s": 0.002},
                                    {"mode": "accelerated", "duration_s": 3.0}])  # fmt: skip
def test_a_straight_path_needs_a_speed(job_of, timing) -> None:
    with pytest.raises(ValueError, match="needs timing mode accelerated with speed_mps"):
        job_of(path={"shape": "straight", "to_m": [0, 0, -0.45]}, timing=timing)
