"""Stepping together: one tick a period, straight between targets, exact at every target."""

from __future__ import annotations

import numpy as np
from hypothesis import example, given, settings
from hypothesis import strategies as st

from deltactl.firmware_py.planner import timing_moves
from deltactl.firmware_py.planner.motion import StepGate
from deltactl.firmware_py.planner.timing_moves import TogetherSchedule

step = st.integers(-60, 60)
ways = st.lists(st.tuples(step, step, step), min_size=1, max_size=12)


def played(schedule: TogetherSchedule, count: int, start_ns: int = 0):
    parts = list(schedule.play(0, count - 1, start_ns, StepGate()))
    due = np.concatenate([np.empty(0, dtype=np.int64), *(part.due_ns for part in parts)])
    steps = np.concatenate([np.empty((0, 3), dtype=np.int8), *(part.steps for part in parts)])
    return due, steps.astype(int)


@settings(max_examples=60, deadline=None)
@given(way=ways, t_pwm_us=st.integers(50, 20_000), dwells=st.lists(st.floats(0, 0.1)))
def test_counts_are_exact_at_each_target_and_ticks_lie_on_the_grid(way, t_pwm_us, dwells):
    counts = np.cumsum(np.array(way), axis=0)
    dwell_s = np.resize(np.array([*dwells, 0.0]), len(way))
    dwell_s[0] = 0.0
    schedule = TogetherSchedule(counts, dwell_s, t_pwm_us * 1e-6)
    due, steps = played(schedule, len(way), start_ns=777)
    assert (np.diff(due) >= t_pwm_us * 1000).all()
    assert ((due - 777) % (t_pwm_us * 1000) == t_pwm_us * 1000 // 2).all()
    assert (np.abs(steps).max(axis=1) == 1).all()
    for target, reached_ns in enumerate(schedule.reached_ns):
        done = due - 777 <= reached_ns
        assert (counts[0] + steps[done].sum(axis=0) == counts[target]).all()
    moving = np.abs(np.diff(counts, axis=0)).max(axis=1, initial=0).sum()
    assert len(due) == moving
    assert schedule.duration_ns == moving * t_pwm_us * 1000 + schedule.rest_ns
    assert schedule.rest_ns * 1e-9 >= dwell_s.sum() - 1e-9
    assert schedule.rest_ns * 1e-9 <= dwell_s.sum() + len(way) * t_pwm_us * 1e-6


@settings(max_examples=60, deadline=None)
@given(delta=st.tuples(*[st.integers(-3000, 3000)] * 3))
def test_steps_keep_within_half_a_step_of_the_straight_line(delta):
    schedule = TogetherSchedule(np.array([[0, 0, 0], delta]), np.zeros(2), 0.001)
    _, steps = played(schedule, 2)
    ticks = len(steps)
    line = np.arange(1, ticks + 1)[:, None] / max(1, ticks) * np.array(delta)
    assert np.abs(np.cumsum(steps, axis=0) - line).max(initial=0.0) <= 0.5 + 1e-9


def test_an_even_motion_is_as_often_ahead_of_its_line_as_behind():
    schedule = TogetherSchedule(np.array([[0, 0, 0], [40, -40, 40]]), np.zeros(2), 0.002)
    due, steps = played(schedule, 2)
    t_ns = np.arange(schedule.duration_ns // 1000) * 1000
    there = np.cumsum(steps[:, 0])[np.searchsorted(due, t_ns, side="right") - 1]
    there[t_ns < due[0]] = 0
    assert abs(float(np.mean(there - 40.0 * t_ns / schedule.duration_ns))) < 0.01


@settings(max_examples=60, deadline=None)
@given(way=ways)
@example(way=[(0, 0, 0), (0, 1, 0), (0, 1, 5)])
@example(way=[(0, 0, 0), (1, 20, 0), (1, 0, 0), (1, 0, 0)])
def test_said_peak_rate_is_the_nearest_pair_of_steps_or_one_period_less(way):
    counts = np.cumsum(np.array(way), axis=0)
    schedule = TogetherSchedule(counts, np.zeros(len(way)), 0.001)
    due, steps = played(schedule, len(way))
    for motor in range(3):
        times = due[steps[:, motor] != 0]
        if len(times) > 1:
            periods = np.diff(times).min() / 1e6
            said = 1000.0 / schedule.peak_rate_hz[motor]
            assert max(1, periods - 1) - 1e-9 <= said <= periods + 1e-9


def test_long_moves_come_in_pieces_that_fit_together(monkeypatch):
    counts = np.array([[0, 0, 0], [9000, -4000, 17], [0, 0, 0], [5, 5, 5]])
    schedule = TogetherSchedule(counts, np.array([0, 0.01, 0, 0]), 50e-6)
    parts = list(schedule.play(0, 3, 0, StepGate()))
    assert max(len(part) for part in parts) == timing_moves._TICKS_AT_ONCE
    monkeypatch.setattr(timing_moves, "_TICKS_AT_ONCE", 10**6)
    (whole,) = schedule.play(0, 3, 0, StepGate())
    assert (np.concatenate([part.due_ns for part in parts]) == whole.due_ns).all()
    assert (np.concatenate([part.steps for part in parts]) == whole.steps).all()


def test_any_stretch_of_targets_can_be_played_alone():
    random = np.random.default_rng(5)
    counts = np.cumsum(random.integers(-9, 10, (50, 3)), axis=0)
    schedule = TogetherSchedule(counts, np.zeros(50), 0.001)
    due, steps = played(schedule, 50)
    pieces = [next(iter(schedule.play(at, at + 7, 0, StepGate()))) for at in range(0, 49, 7)]
    assert (np.concatenate([piece.due_ns for piece in pieces]) == due).all()
    assert (np.concatenate([piece.steps for piece in pieces]) == steps).all()
