"""The stream: exactly the motion that was checked, made lazily, target by target."""

from __future__ import annotations

import itertools
import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_py.planner.check import home_counts, make_plan
from firmware_py.planner.stream import BLOCK, MotionStream
from foundation.errors import MotionError
from models.inverse_kinematics import GeometricInverse

point = st.tuples(st.floats(-0.05, 0.05), st.floats(-0.05, 0.05), st.floats(-0.5, -0.42))
arms = st.tuples(*[st.floats(30.0, 70.0)] * 3)

paths = st.one_of(
    st.builds(
        lambda radius, turns, spacing: {
            "shape": "circle",
            "centre_m": [0, 0, -0.45],
            "radius_m": radius,
            "turns": turns,
            "spacing_m": spacing,
        },
        st.floats(0.005, 0.03),
        st.sampled_from([1, 2, 0.3, -1.5]),
        st.floats(0.0005, 0.01),
    ),
    st.builds(
        lambda points, dwell: {"shape": "points", "points_m": points, "dwell_s": dwell},
        st.lists(point, min_size=1, max_size=3),
        st.sampled_from([0.0, 0.03]),
    ),
    st.builds(
        lambda angles, dwell: {"shape": "joints", "angles_deg": angles, "dwell_s": dwell},
        st.lists(arms, min_size=1, max_size=4),
        st.sampled_from([0.0, 0.03]),
    ),
)
timings = st.one_of(
    st.builds(lambda t: {"mode": "together", "t_pwm_s": t}, st.sampled_from([5e-5, 0.0007, 0.006])),
    st.builds(lambda v: {"mode": "accelerated", "speed_mps": v}, st.floats(0.01, 1.0)),
)


def plan_for(job, robot):
    return make_plan(job, robot, GeometricInverse(robot.geometry))


@settings(max_examples=60, deadline=None)
@given(path=paths, timing=timings, repeats=st.integers(1, 3))
def test_ticks_lead_through_every_target_in_order(zhao, job_of, path, timing, repeats):
    plan = plan_for(job_of(path=path, timing=timing, repeats=repeats), zhao)
    stream = MotionStream(plan, home_counts(zhao))
    chunks = list(stream)
    due = np.concatenate([chunk.ticks.due_ns for chunk in chunks])
    steps = np.concatenate([chunk.ticks.steps for chunk in chunks]).astype(int)
    assert (np.diff(due) > 0).all()
    assert set(np.unique(steps)) <= {-1, 0, 1}
    made = np.concatenate([np.zeros((1, 3), int), np.cumsum(steps, axis=0)]) + home_counts(zhao)

    index = np.concatenate([chunk.reached.index for chunk in chunks])
    assert index.tolist() == list(range(len(index)))
    number = np.concatenate([chunk.reached.number for chunk in chunks])
    repeat = np.concatenate([chunk.reached.repeat for chunk in chunks])
    one_lap = np.arange(len(plan.first.lap))
    skipped = 1 if plan.again is plan.first else 0
    for lap in range(1, repeats + 1):
        on_path = number[(repeat == lap) & (number >= 0)]
        assert on_path.tolist() == one_lap[skipped if lap > 1 else 0 :].tolist()

    t_ns = np.concatenate([chunk.reached.t_ns for chunk in chunks])
    counts = np.concatenate([chunk.reached.counts for chunk in chunks])
    window_ns, gap_ns = plan.first.schedule.gate_ns
    first = np.searchsorted(due, t_ns - window_ns, side="right")
    last = np.searchsorted(due, t_ns + gap_ns, side="right")
    for row in range(len(t_ns)):
        assert (made[first[row] : last[row] + 1] == counts[row]).any(axis=0).all()
    assert tuple(made[-1].tolist()) == plan.last_counts
    until = [chunk.until_ns for chunk in chunks]
    assert until == sorted(until)
    assert until[-1] == stream.end_ns
    assert due.max(initial=0) <= stream.end_ns + gap_ns


@settings(max_examples=20, deadline=None)
@given(path=paths, timing=timings)
def test_the_same_job_gives_the_same_ticks(zhao, job_of, path, timing):
    job = job_of(path=path, timing=timing)
    once = MotionStream(plan_for(job, zhao), home_counts(zhao))
    twice = MotionStream(plan_for(job, zhao), home_counts(zhao))
    for one, other in itertools.zip_longest(once, twice):
        assert one.ticks.due_ns.tolist() == other.ticks.due_ns.tolist()
        assert one.ticks.steps.tolist() == other.ticks.steps.tolist()


class Drifting(GeometricInverse):
    """Answers differently after a while, as a network must not."""

    drift_rad = 0.0

    def angles_rad(self, x_m, y_m, z_m):
        first, second, third = super().angles_rad(x_m, y_m, z_m)
        return first + self.drift_rad, second, third


def test_a_target_that_maps_otherwise_than_when_checked_stops_the_motion(zhao, job_of):
    kinematics = Drifting(zhao.geometry)
    plan = make_plan(job_of(), zhao, kinematics)
    stream = iter(MotionStream(plan, home_counts(zhao)))
    next(stream)
    kinematics.drift_rad = 0.01
    with pytest.raises(MotionError, match=r"point \d+ at .* maps to counts .* check the job again"):
        list(stream)


def test_targets_are_mapped_again_one_by_one_while_it_runs(zhao, job_of):
    class Counting(GeometricInverse):
        calls = 0

        def angles_rad(self, x_m, y_m, z_m):
            self.calls += 1
            return super().angles_rad(x_m, y_m, z_m)

    kinematics = Counting(zhao.geometry)
    path = {"shape": "circle", "centre_m": [0, 0, -0.45], "radius_m": 0.1, "spacing_m": 0.0005}
    plan = make_plan(job_of(path=path, repeats=2), zhao, kinematics)
    targets = len(plan.first.lap)
    assert kinematics.calls == targets
    stream = iter(MotionStream(plan, home_counts(zhao)))
    next(stream)
    next(stream)
    assert kinematics.calls <= targets + 1 + BLOCK
    list(stream)
    assert kinematics.calls == targets + 1 + 2 * (targets - 1)


def test_a_survey_of_100_000_points_is_streamed_in_little_memory(zhao, job_of):
    """30 million steps in all; a few chunks of them must cost what a few chunks hold."""
    path = {"shape": "joints", "angles_deg": [[40, 40, 40], [60, 30, 50]] * 50_000}
    plan = plan_for(job_of(path=path), zhao)
    stream = MotionStream(plan, home_counts(zhao))
    tracemalloc.start()
    ticks = sum(len(chunk.ticks) for chunk in itertools.islice(stream, 60))
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert ticks > 50_000
    assert peak < 5_000_000
    assert stream.end_ns > 50_000 * 100 * 2_000_000


def test_many_repeats_cost_no_planning(zhao, job_of):
    plan = plan_for(job_of(repeats=100_000), zhao)
    assert plan.again is plan.first
    stream = MotionStream(plan, home_counts(zhao))
    assert stream.end_ns == stream.path_start_ns + 100_000 * plan.first.schedule.duration_ns
