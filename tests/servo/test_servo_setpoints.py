"""Set-points become the smooth reference they were cut from."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.drivers.steps.contract import Ticks
from deltactl.firmware_py.servo.loop import Setpoints

STEP_RAD = 1e-4
MS = 1_000_000


def ticks_of(angle_rad: np.ndarray, t_ns: np.ndarray) -> Ticks:
    """A tick wherever a motor's angle (n, 3) passes half a count; straight in between."""
    events: dict[int, list[int]] = {}
    for motor in range(3):
        counts = np.rint(angle_rad[:, motor] / STEP_RAD).astype(int)
        for row in np.flatnonzero(np.diff(counts)):
            sign = int(np.sign(counts[row + 1] - counts[row]))
            half = (counts[row] + 0.5 * sign) * STEP_RAD
            start, end = angle_rad[row, motor], angle_rad[row + 1, motor]
            at = t_ns[row] + (half - start) / (end - start) * (t_ns[row + 1] - t_ns[row])
            events.setdefault(round(at), [0, 0, 0])[motor] = sign
    due = sorted(events)
    return Ticks(
        np.array(due, dtype=np.int64), np.array([events[t] for t in due], np.int8).reshape(-1, 3)
    )


@given(size=st.floats(0.002, 0.02), frequency=st.floats(0.3, 3.0), chunk=st.integers(5, 60))
@settings(max_examples=20, deadline=None)
def test_a_sine_comes_back_to_a_count(size: float, frequency: float, chunk: int) -> None:
    t_ns = np.arange(0, 600 * MS, MS // 10)
    phase = 2 * np.pi * frequency * t_ns * 1e-9
    angle = size * np.stack([np.sin(phase), 1 - np.cos(phase), -np.sin(phase)], axis=-1)
    ticks = ticks_of(angle, t_ns)
    queue, found, done = Setpoints(STEP_RAD, MS // 10), [], 0
    for now_ns in range(0, 600 * MS, chunk * MS):
        ahead = int(np.searchsorted(ticks.due_ns, now_ns + chunk * MS + 20 * MS))
        queue.push(Ticks(ticks.due_ns[done:ahead], ticks.steps[done:ahead]), now_ns)
        done = max(done, ahead)
        found.append(queue.references_rad(now_ns, chunk * 10))
    reference = np.concatenate(found, axis=1).T[: len(angle)]
    assert np.abs(reference - angle).max() < 1.01 * STEP_RAD
    assert queue.counts == tuple(np.rint(angle[-1] / STEP_RAD).astype(int))


def test_what_was_passed_is_told_once() -> None:
    queue = Setpoints(STEP_RAD, MS // 10)
    queue.push(Ticks(np.array([1, 2, 3]) * MS, np.array([[1, 0, 0]] * 3, np.int8)), 0)
    queue.references_rad(0, 26)
    assert queue.take_sent().due_ns.tolist() == [MS, 2 * MS]
    assert len(queue.take_sent()) == 0
    assert (len(queue), queue.counts) == (1, (2, 0, 0))


def test_ahead_of_the_newest_setpoint_the_reference_stands() -> None:
    queue = Setpoints(STEP_RAD, MS // 10)
    queue.push(Ticks(np.array([MS]), np.array([[1, -1, 0]], np.int8)), 0)
    queue.references_rad(0, 10)
    found = queue.references_rad(MS, 990)
    assert found == [[STEP_RAD / 2] * 990, [-STEP_RAD / 2] * 990, [0.0] * 990]
    queue.push(Ticks(np.array([102 * MS]), np.array([[1, 0, 0]], np.int8)), 100 * MS)
    first, _, _ = queue.references_rad(100 * MS, 21)
    assert first[::10] == pytest.approx([0.5 * STEP_RAD, STEP_RAD, 1.5 * STEP_RAD])


def test_a_restart_forgets_what_is_queued() -> None:
    queue = Setpoints(STEP_RAD, MS // 10)
    queue.push(Ticks(np.array([MS]), np.array([[1, 0, 0]], np.int8)), 0)
    queue.restart((7, 8, 9), MS // 2)
    assert queue.references_rad(2 * MS, 1) == [
        [pytest.approx(count * STEP_RAD)] for count in (7, 8, 9)
    ]
    assert len(queue.take_sent()) == 0
