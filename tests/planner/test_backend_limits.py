"""What a step backend cannot keep up with is refused by the dry run, not by the first pulse."""

from __future__ import annotations

import numpy as np
import pytest

from deltactl.firmware_py.compensation.lead import lags_s
from deltactl.firmware_py.compensation.ringing import rings
from deltactl.firmware_py.planner.plan import home_counts, make_plan
from deltactl.firmware_py.planner.stream import MotionStream
from deltactl.foundation.errors import LimitExceeded
from deltactl.models.inverse_kinematics import GeometricInverse
from deltactl.models.robot import EffectEntry

SHORTEST_NS = 2_000_000


@pytest.fixture
def on_gpiozero(zhao):
    return zhao.model_copy(update={"steps": zhao.steps.model_copy(update={"backend": "gpiozero"})})


@pytest.mark.parametrize("t_pwm_s", [0.002, 0.006])
def test_no_two_ticks_of_a_job_are_nearer_than_gpiozero_takes(on_gpiozero, job_of, t_pwm_s):
    job = job_of(timing={"mode": "together", "t_pwm_s": t_pwm_s}, repeats=2)
    plan = make_plan(job, on_gpiozero, GeometricInverse(on_gpiozero.geometry))
    stream = MotionStream(plan, home_counts(on_gpiozero))
    ticks = [chunk.ticks for chunk in stream]
    due_ns = np.concatenate([one.due_ns for one in ticks])
    assert np.diff(due_ns).min() >= SHORTEST_NS
    assert (due_ns < stream.path_start_ns).sum() > 100  # the approach is among them
    made = np.concatenate([one.steps for one in ticks]).sum(axis=0, dtype=np.int64)
    assert (home_counts(on_gpiozero) + made).tolist() == list(plan.last_counts)


@pytest.mark.parametrize(
    ("timing", "says"),
    [
        ({"mode": "together", "t_pwm_s": 0.0005}, "t_pwm_s 0.0005 is shorter than the 0.002 s"),
        ({"mode": "accelerated", "speed_mps": 0.01}, "accelerated timing"),
    ],
)
def test_what_gpiozero_cannot_is_refused_before(on_gpiozero, zhao, job_of, timing, says):
    job = job_of(timing=timing)
    with pytest.raises(LimitExceeded, match=says):
        make_plan(job, on_gpiozero, GeometricInverse(on_gpiozero.geometry))
    make_plan(job, zhao, GeometricInverse(zhao.geometry))


def test_what_gpiozero_cannot_lead_is_commanded_as_if_it_were_not_known(on_gpiozero, job_of):
    late = EffectEntry(effect="following_lag", component="motor1", parameters={"time": 0.1})
    wobbles = EffectEntry(effect="resonance", component="platform", parameters={"frequency": 2.0})
    known = on_gpiozero.model_copy(update={"effects": (late, wobbles)})
    assert not rings(known)
    assert not any(own.any() for own in lags_s(known))
    made = []
    for robot in (on_gpiozero, known):
        job = job_of(timing={"mode": "together", "t_pwm_s": 0.002})
        plan = make_plan(job, robot, GeometricInverse(robot.geometry))
        stream = MotionStream(plan, home_counts(robot))
        made.append(np.concatenate([chunk.ticks.due_ns for chunk in stream]))
    np.testing.assert_array_equal(*made)
