"""Moves in joint space: as fast as the limits allow, never faster, exact at every target."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from deltactl.firmware_py.planner.motion import StepGate
from deltactl.firmware_py.planner.timing_moves import MotorLimits, MoveSchedule

STEP_RAD = 2 * np.pi / 16_000
angle = st.floats(-0.3, 1.9)
ways = st.lists(st.tuples(angle, angle, angle), min_size=2, max_size=4)
limit_sets = st.builds(
    MotorLimits,
    speed_radps=st.floats(0.05, 8.0),
    acceleration_radps2=st.floats(0.5, 100.0),
    step_rate_hz=st.floats(2_000, 20_000),
    rad_per_step=st.just(STEP_RAD),
)


def played(schedule: MoveSchedule) -> tuple[np.ndarray, np.ndarray]:
    gate = StepGate()
    gate.rules(*schedule.gate_ns)
    last = len(schedule.reached_ns) - 1
    parts = list(schedule.play(0, last, 0, gate))
    due = np.concatenate([part.due_ns for part in parts])
    return due, np.concatenate([part.steps for part in parts]).astype(int)


@settings(max_examples=60, deadline=None)
@given(way=ways, limits=limit_sets)
def test_counts_are_exact_at_every_target(way, limits):
    angles = np.array(way)
    schedule = MoveSchedule(angles, np.full(len(way), 0.01), limits)
    due, steps = played(schedule)
    counts = np.rint(angles / STEP_RAD).astype(int)
    window_ns, gap_ns = schedule.gate_ns
    assert gap_ns >= 4.9 * window_ns
    for target, reached_ns in enumerate(schedule.reached_ns):
        made = steps[due <= reached_ns + window_ns].sum(axis=0)
        assert (counts[0] + made == counts[target]).all()
    assert (np.diff(due) >= max(1, window_ns)).all()


@pytest.mark.parametrize("dwell_s", [(0.0, 0.2, 0.5, 0.0), (0.3, 0.0, 0.1, 0.4)])
def test_arms_rest_after_each_target_as_long_as_is_said(dwell_s):
    limits = MotorLimits(8.0, 20.0, 20_000.0, STEP_RAD)
    angles = np.array([[0.3, 0.3, 0.3], [0.5, 0.4, 0.3], [0.2, 0.4, 0.6], [0.3, 0.3, 0.3]])
    schedule = MoveSchedule(angles, np.array(dwell_s), limits)
    due, steps = played(schedule)
    counts = np.rint(angles / STEP_RAD).astype(int)
    for target, reached_ns in enumerate(schedule.reached_ns):
        leaves_ns = reached_ns + round(dwell_s[target] * 1e9)
        for at_ns in (reached_ns, leaves_ns):
            made = steps[due <= at_ns].sum(axis=0)
            assert (counts[0] + made == counts[target]).all()
    assert schedule.duration_ns == leaves_ns


@settings(max_examples=60, deadline=None)
@given(way=ways, limits=limit_sets)
def test_no_steps_come_faster_than_the_limits(way, limits):
    schedule = MoveSchedule(np.array(way), np.zeros(len(way)), limits)
    due, steps = played(schedule)
    nearest_ns = 1e9 / np.minimum(limits.step_rate_hz, limits.speed_radps / STEP_RAD / 0.8)
    for motor in range(3):
        made = steps[:, motor] != 0
        apart, same_way = np.diff(due[made]), np.diff(steps[made, motor]) == 0
        assert (apart[same_way] >= nearest_ns * (1 - 1e-6) - 2).all()
        assert (apart >= 1e9 / limits.step_rate_hz - 2).all()
        assert schedule.peak_rate_hz[motor] <= 0.8 * limits.step_rate_hz * (1 + 1e-9)


@settings(max_examples=100, deadline=None)
@given(way=ways, limits=limit_sets)
def test_a_move_takes_as_long_as_its_slowest_arm_needs(way, limits):
    """The fastest rest-to-rest motion of one arm over an angle has a closed form."""
    angles = np.array(way)
    schedule = MoveSchedule(angles, np.zeros(len(way)), limits)
    v, a = limits.planned_speed_radps, limits.planned_acceleration_radps2
    turn = np.abs(np.diff(angles, axis=0)).max(axis=1)
    assume((turn > 1e-6).all())
    alone = np.where(turn > v * v / a, turn / v + v / a, 2 * np.sqrt(turn / a))
    assert np.diff(schedule.reached_ns) * 1e-9 == pytest.approx(alone, rel=1e-6)


@settings(max_examples=60, deadline=None)
@given(goal=st.tuples(angle, angle, angle), limits=limit_sets)
def test_all_arms_keep_in_proportion(goal, limits):
    """Each motor is within half a step (and a merge window) of the straight line all the way."""
    angles = np.array([[0.0, 0.0, 0.0], goal])
    schedule = MoveSchedule(angles, np.zeros(2), limits)
    _, steps = played(schedule)
    made = np.cumsum(steps, axis=0)
    longest = int(np.argmax(np.abs(angles[1])))
    assume(abs(angles[1, longest]) > 10 * STEP_RAD)
    part = made[:, longest] / (angles[1, longest] / STEP_RAD)
    line = part[:, None] * angles[1] / STEP_RAD
    slip = schedule.gate_ns[0] * 1e-9 * schedule.peak_rate_hz.max()
    assert np.abs(made - line).max() <= 1.0 + slip


def test_platform_speed_can_limit_a_move():
    limits = MotorLimits(8.0, 20.0, 20_000.0, STEP_RAD)
    angles = np.array([[0.3, 0.3, 0.3], [0.9, 0.3, 0.3]])
    free = MoveSchedule(angles, np.zeros(2), limits)
    slow = MoveSchedule(angles, np.zeros(2), limits, fastest=np.array([0.1]))
    assert free.duration_ns < 1e9
    assert slow.duration_ns == pytest.approx(10e9, rel=0.01)


def test_nothing_to_do_takes_no_time():
    limits = MotorLimits(8.0, 20.0, 20_000.0, STEP_RAD)
    schedule = MoveSchedule(np.full((3, 3), 0.5), np.array([0, 0.25, 0.5]), limits)
    assert schedule.reached_ns.tolist() == [0, 0, 250_000_000]
    assert schedule.duration_ns == 750_000_000
    assert len(played(schedule)[0]) == 0
