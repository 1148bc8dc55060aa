"""The stream: exactly the motion that was checked, made lazily, target by target."""

from __future__ import annotations

import itertools
import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.drivers.steps.build import minimum_period_ns
from deltactl.firmware_py.planner import timing_moves
from deltactl.firmware_py.planner.plan import home_counts, make_plan
from deltactl.firmware_py.planner.stream import BLOCK, MotionStream
from deltactl.foundation.clock import VirtualClock
from deltactl.foundation.errors import MotionError
from deltactl.models.inverse_kinematics import GeometricInverse
from deltactl.models.robot import EffectEntry

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


@pytest.mark.study
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

    there = ~np.concatenate([chunk.reached.left for chunk in chunks])
    index = np.concatenate([chunk.reached.index for chunk in chunks])
    assert index[there].tolist() == list(range(there.sum()))
    number = np.concatenate([chunk.reached.number for chunk in chunks])[there]
    repeat = np.concatenate([chunk.reached.repeat for chunk in chunks])[there]
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


@pytest.mark.study
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


def test_steps_of_the_approach_keep_their_distance_too(zhao, job_of):
    """Each motor comes to its half counts in its own time, and pulses need room."""
    plan = plan_for(job_of(path={"shape": "joints", "angles_deg": [[71, 40, 33]]}), zhao)
    stream = MotionStream(plan, home_counts(zhao))
    due = np.concatenate([chunk.ticks.due_ns for chunk in stream])
    assert len(due) > 100
    window_ns, _ = stream.approach.gate_ns
    assert window_ns > 1000
    assert np.diff(due).min() >= window_ns


@pytest.mark.parametrize("pulse_width_us", [5.0, 40.0])
def test_fast_motors_make_no_ticks_that_the_output_refuses(zhao, job_of, pulse_width_us):
    """Above 4000 steps a second of each motor the ticks of three would come nearer than 50 us."""
    steps = zhao.steps.model_copy(update={"pulse_width_us": pulse_width_us})
    robot = zhao.model_copy(update={"steps": steps})
    circle = {"shape": "circle", "centre_m": [0, 0, -0.45], "radius_m": 0.1, "spacing_m": 0.0005}
    job = job_of(path=circle, timing={"mode": "accelerated", "speed_mps": 6.0})
    plan = plan_for(job, robot)
    ticks = [chunk.ticks for chunk in MotionStream(plan, home_counts(robot))]
    due_ns = np.concatenate([one.due_ns for one in ticks])
    assert plan.first.schedule.peak_rate_hz.min() > 4000.0
    assert np.diff(due_ns).min() + 1 >= minimum_period_ns(steps, VirtualClock())
    moved = np.concatenate([one.steps for one in ticks])
    for motor in range(3):
        apart_ns = np.diff(due_ns[moved[:, motor] != 0])
        assert apart_ns.min() * 1e-9 >= 1.0 / robot.limits.step_rate_hz - 1e-9


def test_a_target_comes_with_the_chunk_in_whose_time_it_is_reached(zhao, job_of, monkeypatch):
    """Only the last of a block is kept back, until the last tick towards it is known."""
    monkeypatch.setattr(timing_moves, "_TICKS_AT_ONCE", 50)
    angles = [[40, 40, 40], [41, 40, 40], [42, 40, 40], [60, 40, 40]]
    plan = plan_for(job_of(path={"shape": "joints", "angles_deg": angles}), zhao)
    stream = MotionStream(plan, home_counts(zhao))
    until_ns, seen = -1, []
    for chunk in stream:
        seen += chunk.reached.number.tolist()
        assert (chunk.reached.t_ns > until_ns).all()
        until_ns = chunk.until_ns
    assert seen == [0, 1, 2, 3]


@pytest.mark.parametrize(
    ("effect", "component", "parameters"),
    [
        ("following_lag", "motor3", {"time": 0.05}),
        ("resonance", "platform", {"frequency": 2.4, "damping": 0.1}),
    ],
)
def test_the_first_target_is_reached_when_the_stream_says_so(
    zhao, job_of, effect, component, parameters
):
    """Also where steps are moved ahead of late drives, or away from what makes it ring."""
    entry = EffectEntry(effect=effect, component=component, parameters=parameters)
    robot = zhao.model_copy(update={"effects": (entry,)})
    path = {"shape": "points", "points_m": [[0, 0, -0.45], [0.02, 0, -0.45]], "dwell_s": 0.3}
    timing = {"mode": "accelerated", "speed_mps": 0.1}
    stream = MotionStream(
        plan_for(job_of(path=path, timing=timing, repeats=2), robot), home_counts(robot)
    )
    chunks = list(stream)
    reached = [int(t) for chunk in chunks for t in chunk.reached.t_ns]
    assert reached[0] == stream.path_start_ns > stream.approach.duration_ns
    steps = sum(chunk.ticks.steps.sum(axis=0, dtype=int) for chunk in chunks)
    assert tuple((steps + home_counts(robot)).tolist()) == stream.plan.last_counts


def test_a_further_lap_begins_at_the_last_target(zhao, job_of):
    points = [[0, 0, -0.45], [0.02, 0, -0.45], [0, 0.02, -0.45]]
    job = job_of(path={"shape": "points", "points_m": points, "spacing_m": 0.01}, repeats=2)
    plan = plan_for(job, zhao)
    lap, last = plan.again.lap, int(plan.first.lap.number[-1])
    back = len(lap) - len(plan.first.lap) - 1
    assert lap.number.tolist() == [last, *[-1] * back, *range(last + 1)]
    assert lap.counts[0].tolist() == plan.first.lap.counts[-1].tolist()
