"""A turn of one arm by hand, and every move by hand where all motors step together."""

from __future__ import annotations

import numpy as np
import pytest

from deltactl.firmware_py.planner.plan import Plan, make_plan
from deltactl.firmware_py.planner.stream import MotionStream
from deltactl.models.inverse_kinematics import GeometricInverse
from deltactl.models.linkage import Linkage, forward

FROM_DEG, TO_DEG = (50.0, 50.0, 50.0), (60.0, 50.0, 50.0)


@pytest.fixture(params=["pulse", "gpiozero"])
def robot(zhao, request):
    steps = zhao.steps.model_copy(update={"backend": request.param})
    return zhao.model_copy(update={"steps": steps})


def planned(robot, job_of, path, speed_mps: float, **further: float) -> Plan:
    timing = {"mode": "accelerated", "speed_mps": speed_mps} | further
    return make_plan(job_of(path=path, timing=timing), robot, GeometricInverse(robot.geometry))


def counts_of(robot, angles_deg) -> tuple[int, ...]:
    return tuple(round(np.deg2rad(one) / robot.drive.rad_per_step) for one in angles_deg)


def fastest_mps(plan: Plan, start) -> tuple[float, float]:
    """Of the platform over a tenth of the way, and the joint speed [rad/s] there."""
    ticks = [one.ticks for one in MotionStream(plan, start)]
    t_s = np.concatenate([one.due_ns for one in ticks]) * 1e-9
    steps = np.concatenate([one.steps for one in ticks])
    assert np.diff(t_s).min() >= plan.robot.steps.shortest_period_s - 1e-9
    angles_rad = (np.array(start) + np.cumsum(steps, axis=0)) * plan.robot.drive.rad_per_step
    place_m = forward(Linkage.of(plan.robot.geometry), angles_rad).position_m
    later = len(t_s) // 10
    took_s = t_s[later:] - t_s[:-later]
    hop_m = np.linalg.norm(place_m[later:] - place_m[:-later], axis=1)
    turn_rad = np.abs(angles_rad[later:] - angles_rad[:-later]).max(axis=1)
    return float((hop_m / took_s).max()), float((turn_rad / took_s).max())


@pytest.mark.parametrize("speed_mps", [0.005, 0.02])
def test_one_arm_turns_as_slowly_as_is_asked(robot, job_of, speed_mps: float) -> None:
    """It went at limits.approach_speed_radps, whatever was asked for: 0.1 m/s and more."""
    path = {"shape": "joints", "angles_deg": [TO_DEG]}
    plan = planned(robot, job_of, path, speed_mps)
    seen_mps, _ = fastest_mps(plan, counts_of(robot, FROM_DEG))
    assert 0.8 * speed_mps < seen_mps < 1.05 * speed_mps


def test_and_faster_than_on_the_way_to_a_path_within_the_limits_of_file_and_job(
    zhao, job_of
) -> None:
    path = {"shape": "joints", "angles_deg": [TO_DEG]}
    start = counts_of(zhao, FROM_DEG)
    _, of_file = fastest_mps(planned(zhao, job_of, path, 10.0), start)
    assert zhao.limits.approach_speed_radps < of_file < 1.01 * zhao.limits.joint_speed_radps
    _, of_job = fastest_mps(planned(zhao, job_of, path, 10.0, joint_speed_radps=0.2), start)
    assert of_job == pytest.approx(0.2, rel=0.02)


def test_all_motors_together_go_straight_and_no_faster(robot, job_of) -> None:
    """goto, jog and the page were refused on the gpiozero backend, whose jobs may run."""
    start = counts_of(robot, FROM_DEG)
    path = {"shape": "straight", "to_m": [0.02, 0.01, -0.45]}
    plan = planned(robot, job_of, path, 0.01)
    seen_mps, _ = fastest_mps(plan, start)
    assert 0.007 < seen_mps < 0.0105
    made = sum(one.ticks.steps.sum(axis=0, dtype=np.int64) for one in MotionStream(plan, start))
    assert (np.array(start) + made).tolist() == list(plan.last_counts)
