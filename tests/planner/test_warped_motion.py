"""Pausing: on the path, within the acceleration limit, losing nothing."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.drivers.steps.contract import Ticks
from deltactl.firmware_py.planner.motion import NOTHING_REACHED, Chunk
from deltactl.firmware_py.planner.plan import home_counts, make_plan
from deltactl.firmware_py.planner.stream import MotionStream
from deltactl.firmware_py.planner.time_scaling import Pacing, TimeScaledMotion
from deltactl.models.inverse_kinematics import GeometricInverse

MS = 1_000_000
PERIOD_NS = 1 * MS


def metronome(ticks: int, per_chunk: int = 37):
    """Motor 1 steps every millisecond; the motion ends 5 ms after the last step."""
    for first in range(0, ticks, per_chunk):
        last = min(first + per_chunk, ticks)
        due = np.arange(first + 1, last + 1) * PERIOD_NS
        steps = np.zeros((last - first, 3), dtype=np.int8)
        steps[:, 0] = 1
        yield Chunk(Ticks(due, steps), NOTHING_REACHED, int(due[-1]))
    yield Chunk(Ticks(due[:0], steps[:0]), NOTHING_REACHED, ticks * PERIOD_NS + 5 * MS)


def taken(motion: TimeScaledMotion, until_ns: int, every_ns: int = 20 * MS) -> np.ndarray:
    """Run times of all ticks, taken as the controller would."""
    start = motion._taken_ns
    due = [motion.take(at).ticks.due_ns for at in range(start + every_ns, until_ns + 1, every_ns)]
    return np.concatenate([*due, motion.take(until_ns).ticks.due_ns])


def test_without_a_pause_times_are_those_of_the_plan():
    motion = TimeScaledMotion(metronome(1000), 0.2)
    due = taken(motion, 1004 * MS)
    assert due.tolist() == (np.arange(1, 1001) * PERIOD_NS).tolist()
    assert motion.pacing() is Pacing.RUNNING
    motion.take(1005 * MS + 1)
    assert motion.pacing() is Pacing.DONE


def test_a_pause_slows_down_evenly_holds_and_goes_on():
    motion = TimeScaledMotion(metronome(1000), 0.2)
    before = taken(motion, 300 * MS)
    motion.pause(300 * MS)
    assert motion.pacing() is Pacing.SLOWING
    slowing = taken(motion, 500 * MS)
    # From rate 1 to 0 in 200 ms is 100 ms of motion.
    assert len(slowing) == 100
    assert (np.diff(np.diff(slowing)) >= -1).all()
    # Half way down the ramp three quarters of that are behind it.
    assert [motion.motion_ns(at * MS) for at in (400, 500)] == [375 * MS, 400 * MS]
    assert np.searchsorted(slowing, 400 * MS, side="right") == 75
    held = taken(motion, 900 * MS)
    assert len(held) == 0
    assert motion.pacing() is Pacing.HELD
    assert motion.motion_ns(900 * MS) == 400 * MS
    motion.resume(900 * MS)
    after = taken(motion, 1900 * MS)
    everything = np.concatenate([before, slowing, after])
    assert len(everything) == 1000
    assert (np.diff(everything) >= PERIOD_NS).all()
    assert np.diff(everything)[-100:].max() == PERIOD_NS
    assert motion.pacing() is Pacing.DONE


def test_cancel_slows_down_and_drops_the_rest():
    motion = TimeScaledMotion(metronome(1000), 0.2)
    taken(motion, 300 * MS)
    motion.cancel(300 * MS)
    motion.resume(310 * MS)  # too late
    due = taken(motion, 700 * MS)
    assert len(due) == 100
    assert motion.pacing() is Pacing.DONE
    assert motion.cancelled


def test_what_is_due_before_a_change_of_pace_keeps_its_time():
    motion = TimeScaledMotion(metronome(1000), 0.2)
    motion.pause(250 * MS)
    due = taken(motion, 600 * MS)
    assert due[:250].tolist() == (np.arange(1, 251) * PERIOD_NS).tolist()
    assert len(due) == 350


changes = st.lists(st.tuples(st.integers(1, 400), st.sampled_from(["pause", "resume"])), max_size=8)


@pytest.mark.study
@settings(max_examples=25, deadline=None)
@given(changes=changes, every_ms=st.integers(1, 60), ramp_ms=st.integers(1, 300))
def test_any_changes_of_pace_lose_nothing_and_never_bunch(changes, every_ms, ramp_ms):
    motion = TimeScaledMotion(metronome(500), ramp_ms * 1e-3)
    due, now = [], 0
    for wait_ms, change in changes:
        now += wait_ms * MS
        due.append(taken(motion, now, every_ms * MS))
        getattr(motion, change)(now)
    motion.resume(now)
    due.append(taken(motion, now + 1200 * MS, every_ms * MS))
    everything = np.concatenate(due)
    assert len(everything) == 500
    assert (np.diff(everything) >= PERIOD_NS - 2).all()
    assert motion.pacing() is Pacing.DONE


@settings(max_examples=12, deadline=None)
@given(pause_part=st.floats(0.1, 0.9), speed_mps=st.floats(0.05, 0.6), seed=st.integers(0, 3))
def test_pausing_a_real_motion_keeps_the_acceleration_limit(
    zhao, job_of, pause_part, speed_mps, seed
):
    """The plan leaves a fifth of the limit; the ramp needs no more. Same measure as for curves."""
    step_rad, limit = zhao.drive.rad_per_step, zhao.limits.joint_acceleration_radps2
    path = {"shape": "heart", "centre_m": [0, 0, -0.45], "width_m": 0.08 + 0.04 * seed}
    timing = {"mode": "accelerated", "speed_mps": speed_mps}
    plan = make_plan(job_of(path=path, timing=timing), zhao, GeometricInverse(zhao.geometry))
    stream = MotionStream(plan, home_counts(zhao))
    motion = TimeScaledMotion(iter(stream), plan.ramp_s)
    path_ns = stream.end_ns - stream.path_start_ns
    pause_ns = stream.path_start_ns + round(pause_part * path_ns)
    chunks = [motion.take(pause_ns)]
    motion.pause(pause_ns)
    resume_ns = pause_ns + round(2e9 * plan.ramp_s)
    chunks.append(motion.take(resume_ns))
    # Slow enough, the end may come before the standstill.
    assert motion.pacing() in (Pacing.HELD, Pacing.DONE)
    motion.resume(resume_ns)
    chunks.append(motion.take(resume_ns + stream.end_ns + round(2e9 * plan.ramp_s)))
    assert motion.pacing() is Pacing.DONE
    due = np.concatenate([chunk.ticks.due_ns for chunk in chunks])
    steps = np.concatenate([chunk.ticks.steps for chunk in chunks]).astype(int)
    assert tuple((steps.sum(axis=0) + home_counts(zhao)).tolist()) == plan.last_counts
    for motor in range(3):
        made = steps[:, motor] != 0
        t, sign = due[made] * 1e-9, steps[made, motor]
        angle = (np.cumsum(sign) - sign / 2) * step_rad
        one = np.arange(len(t))
        two = np.searchsorted(t, t + 0.02).clip(max=len(t) - 1)
        three = np.searchsorted(t, t[two] + 0.02).clip(max=len(t) - 1)
        apart = (two > one) & (three > two)
        one, two, three = one[apart], two[apart], three[apart]
        before, after = t[two] - t[one], t[three] - t[two]
        change = (angle[three] - angle[two]) / after - (angle[two] - angle[one]) / before
        measured = np.abs(2 * change / (before + after))
        window_s = plan.first.schedule.gate_ns[0] * 1e-9
        speed = plan.first.schedule.peak_rate_hz[motor] * step_rad
        misplaced = speed * window_s + step_rad / 16
        allowance = 4 * misplaced * (1 / before + 1 / after) / (before + after)
        assert (measured - allowance).max() <= limit


def test_ticks_on_a_ramp_are_handed_out_before_they_are_due():
    motion = TimeScaledMotion(metronome(1000), 0.2)
    taken(motion, 300 * MS)
    motion.pause(300 * MS)
    assert len(motion.take(400 * MS).ticks) == 75
    motion.resume(400 * MS)
    # From half the speed to all of it in 100 ms.
    assert len(motion.take(500 * MS).ticks) == 75


def test_no_time_is_lost_to_rounding_over_days():
    def late():
        due = np.array([3 * 86_400 * 10**9 + 1])
        yield Chunk(Ticks(due, np.array([[1, 0, 0]], dtype=np.int8)), NOTHING_REACHED, int(due[0]))

    motion = TimeScaledMotion(late(), 0.2)
    motion.pause(MS)
    motion.take(10**9)
    motion.resume(10**9)
    moved = motion.take(4 * 86_400 * 10**9).ticks.due_ns[0] - 3 * 86_400 * 10**9
    # 0.1 s lost in each ramp, and the time held.
    assert moved == pytest.approx(10**9 - MS, abs=3)
