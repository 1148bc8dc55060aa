"""Curves with limited speed and acceleration, measured on the steps that come out.

The measure: for three steps of one motor at t0 < t1 < t2 the second divided difference of its
angle is a mean of its acceleration, so it lies within the limit. A step made is not exactly
where the plan has it: its time is moved by up to a merge window g, and interpolation misplaces
it by up to 1/8 of the change of speed within an eighth of a piece, taken as step / 16. With
e = v g + step / 16 for each of the three, twice the divided difference moves by at most
4 e (1 / (t1 - t0) + 1 / (t2 - t1)) / (t2 - t0). That allowance is computed for each triple; the
steps are taken about 20 ms apart, where it is a few to some twenty percent of the limit.
"""

from __future__ import annotations

import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.firmware_py.paths.shapes import heart, points
from deltactl.firmware_py.planner.motion import StepGate
from deltactl.firmware_py.planner.plan import motor_limits
from deltactl.firmware_py.planner.timing_accelerated import CurveSchedule
from deltactl.firmware_py.planner.timing_moves import MotorLimits
from deltactl.models.linkage import Linkage, inverse

STEP_RAD = 2 * np.pi / 16_000
H_S = 0.02


def schedule_of(zhao, path, speed_mps, limits) -> tuple[CurveSchedule, np.ndarray]:
    angles = inverse(Linkage.of(zhao.geometry), path.targets).angles_rad
    made = CurveSchedule(angles, path.targets, path.rest, path.dwell_s, speed_mps, limits)
    return made, np.rint(angles / STEP_RAD).astype(int)


def played(schedule, block: int = 10**9) -> tuple[np.ndarray, np.ndarray]:
    gate = StepGate()
    gate.rules(*schedule.gate_ns)
    end = len(schedule.reached_ns) - 1
    parts = [
        ticks
        for first in range(0, end, block)
        for ticks in schedule.play(first, min(first + block, end), 0, gate)
    ]
    due = np.concatenate([part.due_ns for part in parts])
    return due, np.concatenate([part.steps for part in parts]).astype(int)


def accelerations(due_ns, steps, motor, window_ns) -> tuple[np.ndarray, np.ndarray]:
    """Mean accelerations over about H_S of one motor, and how far each may be off."""
    made = steps[:, motor] != 0
    t = due_ns[made] * 1e-9
    sign = steps[made, motor]
    # Step k takes the angle past the middle between two counts.
    angle = (np.cumsum(sign) - sign / 2) * STEP_RAD
    first = np.arange(len(t))
    second = np.searchsorted(t, t + H_S)
    good = second < len(t)
    first, second = first[good], second[good]
    third = np.searchsorted(t, t[second] + H_S)
    good = third < len(t)
    first, second, third = first[good], second[good], third[good]
    before, after = t[second] - t[first], t[third] - t[second]
    speed_before = (angle[second] - angle[first]) / before
    speed_after = (angle[third] - angle[second]) / after
    measured = 2 * (speed_after - speed_before) / (before + after)
    fastest = np.abs(np.gradient(angle, t)).max() if len(t) > 2 else 0.0
    misplaced = fastest * window_ns * 1e-9 + STEP_RAD / 16
    return measured, 4 * misplaced * (1 / before + 1 / after) / (before + after)


limit_sets = st.builds(
    MotorLimits,
    speed_radps=st.floats(0.2, 6.0),
    acceleration_radps2=st.floats(1.0, 60.0),
    step_rate_hz=st.just(20_000.0),
    rad_per_step=st.just(STEP_RAD),
)
corner = st.tuples(st.floats(-0.1, 0.1), st.floats(-0.1, 0.1), st.floats(-0.55, -0.38))


@settings(max_examples=25, deadline=None)
@given(
    width_m=st.floats(0.02, 0.2),
    speed_mps=st.floats(0.02, 1.0),
    spacing_m=st.floats(0.0005, 0.01),
    limits=limit_sets,
)
def test_heart_keeps_the_acceleration_limit_even_at_its_cusps(
    zhao, width_m, speed_mps, spacing_m, limits
):
    path = heart((0, 0, -0.45), width_m, 1, spacing_m)
    schedule, _ = schedule_of(zhao, path, speed_mps, limits)
    due, steps = played(schedule)
    for motor in range(3):
        measured, allowance = accelerations(due, steps, motor, schedule.gate_ns[0])
        excess = np.abs(measured) - allowance - limits.planned_acceleration_radps2
        assert excess.max(initial=-1.0) <= 0.0


@settings(max_examples=25, deadline=None)
@given(
    way=st.lists(corner, min_size=2, max_size=4),
    speed_mps=st.floats(0.02, 1.0),
    spacing_m=st.floats(0.0005, 0.02),
    limits=limit_sets,
)
def test_lines_keep_the_limits_and_rest_at_corners(zhao, way, speed_mps, spacing_m, limits):
    path = points(way, 0.05, spacing_m)
    schedule, counts = schedule_of(zhao, path, speed_mps, limits)
    due, steps = played(schedule)
    window_ns = schedule.gate_ns[0]
    for motor in range(3):
        measured, allowance = accelerations(due, steps, motor, window_ns)
        excess = np.abs(measured) - allowance - limits.planned_acceleration_radps2
        assert excess.max(initial=-1.0) <= 0.0
        apart = np.diff(due[steps[:, motor] != 0])
        assert (apart >= 1e9 / 20_000 - 2).all()
    rests_ns = schedule.reached_ns[path.rest]
    for reached_ns in rests_ns[:-1]:
        resting = (due > reached_ns + 6 * window_ns) & (due < reached_ns + 49_000_000)
        assert not resting.any()
    made = np.concatenate([[counts[0]], counts[0] + np.cumsum(steps, axis=0)])
    for target, reached_ns in enumerate(schedule.reached_ns):
        # Merging moves a step by a window; a motor that turns round may wait for a gap.
        around = [reached_ns - window_ns, reached_ns + schedule.gate_ns[1]]
        first, last = np.searchsorted(due, around, side="right")
        assert (made[first : last + 1] == counts[target]).any(axis=0).all()


@settings(max_examples=20, deadline=None)
@given(block=st.integers(1, 40), spacing_m=st.floats(0.001, 0.01))
def test_playing_in_blocks_gives_the_same_ticks(zhao, block, spacing_m):
    limits = MotorLimits(4.0, 20.0, 20_000.0, STEP_RAD)
    path = heart((0, 0, -0.45), 0.05, 1, spacing_m)
    schedule, _ = schedule_of(zhao, path, 0.2, limits)
    due, steps = played(schedule)
    due_too, steps_too = played(schedule, block)
    assert due.tolist() == due_too.tolist()
    assert steps.tolist() == steps_too.tolist()


def test_a_slow_line_runs_at_the_speed_asked_for(zhao, job_of):
    path = points([(-0.1, 0, -0.45), (0.1, 0, -0.45)], 0.0, 0.0005)
    schedule, _ = schedule_of(zhao, path, 0.05, motor_limits(job_of(), zhao))
    assert schedule.duration_ns * 1e-9 == pytest.approx(0.2 / 0.05, rel=0.01)


def test_a_fast_line_takes_hardly_longer_than_its_fastest_arm_alone(zhao):
    """No path can be faster than its widest arm movement from rest to rest."""
    limits = MotorLimits(100.0, 10.0, 500_000.0, STEP_RAD)
    path = points([(-0.1, 0.05, -0.45), (0.1, -0.02, -0.5)], 0.0, 0.0005)
    schedule, counts = schedule_of(zhao, path, 10.0, limits)
    turn = np.abs(counts[-1] - counts[0]).max() * STEP_RAD
    alone_s = 2 * np.sqrt(turn / limits.planned_acceleration_radps2)
    assert alone_s <= schedule.duration_ns * 1e-9 <= 1.25 * alone_s


@pytest.mark.study
@pytest.mark.realtime
def test_looking_ahead_takes_time_in_proportion_to_the_targets(zhao):
    """A factor, because processor time in seconds depends on what else the machine does."""
    limits = MotorLimits(8.0, 20.0, 20_000.0, STEP_RAD)

    def took_s(path):
        angles = inverse(Linkage.of(zhao.geometry), path.targets).angles_rad
        begin_s = time.process_time()
        CurveSchedule(angles, path.targets, path.rest, path.dwell_s, 0.5, limits)
        return time.process_time() - begin_s

    short, long = heart((0, 0, -0.45), 0.2, 2, 0.000255), heart((0, 0, -0.45), 0.2, 20, 0.000255)
    assert len(short) < 5_100
    assert len(long) >= 50_000
    tries = [(took_s(short), took_s(long)) for _ in range(3)]  # in turns: a load meets both
    assert min(long_s / short_s for short_s, long_s in tries) < 20.0
