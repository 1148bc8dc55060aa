"""The dry run's figures, against what the stream really does and against the papers."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.firmware_py.planner.plan import home_counts, make_plan
from deltactl.firmware_py.planner.stream import MotionStream
from deltactl.firmware_py.planner.summary import summarise
from deltactl.models.inverse_kinematics import GeometricInverse

timings = st.sampled_from(
    [
        {"mode": "together", "t_pwm_s": 0.002},
        {"mode": "together", "t_pwm_s": 5e-5},
        {"mode": "accelerated", "speed_mps": 0.05},
        {"mode": "accelerated", "speed_mps": 2.0},
    ]
)
CENTRE = [0.0, 0.0, -0.45]
paths = st.sampled_from(
    [
        {"shape": "circle", "centre_m": CENTRE, "radius_m": 0.05, "spacing_m": 0.002},
        {
            "shape": "spiral",
            "centre_m": CENTRE,
            "inner_radius_m": 0.01,
            "outer_radius_m": 0.05,
            "turns": 1,
        },
        {"shape": "points", "points_m": [CENTRE, [0.05, 0, -0.5]], "dwell_s": 0.1},
        {"shape": "survey", "count": 12, "dwell_s": 0.2},
    ]
)


@settings(max_examples=25, deadline=None)
@given(path=paths, timing=timings, repeats=st.integers(1, 3))
def test_figures_are_those_of_the_motion(zhao, job_of, path, timing, repeats):
    job = job_of(path=path, timing=timing, repeats=repeats)
    plan = make_plan(job, zhao, GeometricInverse(zhao.geometry))
    summary = summarise(plan, home_counts(zhao))
    stream = MotionStream(plan, home_counts(zhao))
    chunks = list(stream)
    due = np.concatenate([chunk.ticks.due_ns for chunk in chunks])
    steps = np.concatenate([chunk.ticks.steps for chunk in chunks])
    assert summary.duration_s == pytest.approx(chunks[-1].until_ns * 1e-9)
    on_path = due > stream.path_start_ns
    window_s = max(plan.first.schedule.gate_ns[0], 0) * 1e-9
    for motor in range(3):
        made = on_path & (steps[:, motor] != 0)
        same_way = np.diff(steps[made, motor]) == 0
        apart_s = np.diff(due[made])[same_way] * 1e-9
        if len(apart_s):
            # Merging may bring two steps nearer by a window.
            assert apart_s.min() >= 1 / summary.peak_step_rate_hz[motor] - window_s - 2e-9
        assert summary.peak_step_rate_hz[motor] <= zhao.limits.step_rate_hz
    rests = repeats * {"points": 2, "survey": 12}.get(path["shape"], 0) * path.get("dwell_s", 0.0)
    path_s = summary.duration_s - summary.approach_s
    periods_s = repeats * 13 * timing.get("t_pwm_s", 0.0)
    assert path_s - rests - periods_s <= summary.moving_s + 1e-6 <= path_s - rests + 2e-6
    assert summary.mean_speed_mps == pytest.approx(summary.path_length_m / summary.moving_s)
    if "speed_mps" in timing:
        assert summary.mean_speed_mps <= timing["speed_mps"] * 1.001
        assert summary.path_per_step_period_m is None
    assert summary.smallest_margin >= zhao.limits.singularity_margin
    places = np.concatenate([chunk.reached.position_m for chunk in chunks])
    low, high = np.array(summary.box_m).T
    assert (places >= low - 1e-12).all()
    assert (places <= high + 1e-12).all()
    angles = np.rad2deg(np.concatenate([chunk.reached.angles_rad for chunk in chunks]))
    assert np.array(summary.arm_range_deg)[:, 0] == pytest.approx(angles.min(axis=0))
    assert np.array(summary.arm_range_deg)[:, 1] == pytest.approx(angles.max(axis=0))


@pytest.mark.parametrize("t_pwm_s", [0.002, 0.006, 0.01, 0.02])
def test_path_per_step_period_is_a_constant_as_in_zhaos_table_4(zhao, job_of, t_pwm_s):
    """Table 4 times T_PWM is 0.09305 mm; a step moves the end of the upper arm by 0.098 mm.

    Its paths are not published in size or height. What must agree is that the figure does not
    depend on T_PWM, and that it lies near the step of the arm's end.
    """
    path = {"shape": "circle", "centre_m": CENTRE, "radius_m": 0.1, "spacing_m": 0.0005}
    job = job_of(path=path, timing={"mode": "together", "t_pwm_s": t_pwm_s})
    plan = make_plan(job, zhao, GeometricInverse(zhao.geometry))
    per_period_mm = 1e3 * summarise(plan, home_counts(zhao)).path_per_step_period_m
    assert per_period_mm == pytest.approx(0.1197, abs=0.0002)
    arm_end_mm = 250.0 * zhao.drive.rad_per_step
    assert arm_end_mm == pytest.approx(0.0982, abs=1e-4)
    assert 0.7 < per_period_mm / arm_end_mm < 1.5


def test_it_is_plain_data(zhao, job_of):
    plan = make_plan(job_of(), zhao, GeometricInverse(zhao.geometry))
    said = json.loads(json.dumps(summarise(plan, home_counts(zhao)).as_json()))
    assert said["targets"] == 316
    assert said["timing"] == "together, T_PWM 0.002 s"
