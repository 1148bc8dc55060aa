"""The step gate: steps become ticks without bunching, losing or moving any of them far."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.firmware_py.planner.motion import StepGate

WINDOW_NS, GAP_NS = 50_000, 250_000

spaced = st.lists(st.integers(GAP_NS, 4 * GAP_NS), max_size=40)
fast = st.lists(st.integers(WINDOW_NS + 10_000, 3 * WINDOW_NS), max_size=80)
starts = st.tuples(*[st.integers(0, 2 * GAP_NS)] * 3)


def gate(gap_ns: int = GAP_NS) -> StepGate:
    made = StepGate()
    made.rules(WINDOW_NS, gap_ns)
    return made


def times(start: int, gaps: list[int]) -> np.ndarray:
    return start + np.cumsum(np.array(gaps, dtype=np.int64))


@settings(max_examples=60, deadline=None)
@given(
    begin=starts,
    gaps=st.tuples(spaced, spaced, spaced) | st.tuples(fast, fast, fast),
    seed=st.integers(0, 9),
)
def test_steps_that_keep_their_gap_move_by_less_than_a_window(begin, gaps, seed):
    """Fast motors leave little more than a window between their steps: chains without an end."""
    random = np.random.default_rng(seed)
    due = [times(start, gap) for start, gap in zip(begin, gaps, strict=True)]
    signs = [random.choice([-1, 1], len(one)) for one in due]
    least_ns = min((gap for one in gaps for gap in one[1:]), default=GAP_NS)
    ticks = gate(min(GAP_NS, least_ns)).ticks(due, signs)
    assert (np.diff(ticks.due_ns) >= WINDOW_NS).all()
    assert (np.abs(ticks.steps).max(axis=1) == 1).all() if len(ticks) else True
    for motor in range(3):
        made = ticks.steps[:, motor] != 0
        moved = due[motor] - ticks.due_ns[made]
        assert (ticks.steps[made, motor] == signs[motor]).all()
        assert (moved >= 0).all()
        assert (moved < WINDOW_NS).all()


@settings(max_examples=60, deadline=None)
@given(
    gaps=st.tuples(*[st.lists(st.integers(0, 2 * GAP_NS), max_size=30)] * 3),
    cut=st.integers(0, 10_000_000),
)
def test_any_steps_are_kept_apart_also_from_one_call_to_the_next(gaps, cut):
    """Steps that come too fast (a motor turning round) are held back, never lost or swapped."""
    due = [times(0, gap) for gap in gaps]
    one = gate()
    parts = [
        one.ticks(
            [t[t < cut] for t in due], [np.ones(int((t < cut).sum()), int) for t in due], cut
        ),
        one.ticks([t[t >= cut] for t in due], [np.ones(int((t >= cut).sum()), int) for t in due]),
    ]
    assert (parts[0].due_ns <= cut - WINDOW_NS).all()
    due_ns = np.concatenate([part.due_ns for part in parts])
    steps = np.concatenate([part.steps for part in parts])
    assert (np.diff(due_ns) >= WINDOW_NS).all()
    assert steps.sum(axis=0).tolist() == [len(t) for t in due]
    for motor in range(3):
        made = due_ns[steps[:, motor] != 0]
        # Merging may take a window from a gap, and no more.
        assert (np.diff(made) >= GAP_NS - WINDOW_NS).all()


def test_steps_at_the_same_time_are_one_tick():
    at = np.array([1_000_000])
    ticks = gate().ticks([at, at, at], [np.array([1]), np.array([-1]), np.array([1])])
    assert ticks.due_ns.tolist() == [1_000_000]
    assert ticks.steps.tolist() == [[1, -1, 1]]


def test_the_third_of_three_in_a_row_may_begin_a_tick_of_its_own():
    due = [np.array([0]), np.array([40_000]), np.array([60_000])]
    ticks = gate().ticks(due, [np.array([1])] * 3)
    assert ticks.due_ns.tolist() == [0, 60_000]
    assert ticks.steps.tolist() == [[1, 1, 0], [0, 0, 1]]


@settings(max_examples=40, deadline=None)
@given(begin=starts, gaps=st.tuples(spaced, spaced, spaced), cut=st.integers(0, 20_000_000))
def test_cutting_a_motion_into_calls_changes_nothing(begin, gaps, cut):
    due = [times(start, gap) for start, gap in zip(begin, gaps, strict=True)]
    ones = [np.ones(len(one), dtype=np.int64) for one in due]
    whole = gate().ticks(due, ones)
    cut_gate = gate()
    early = [one < cut for one in due]
    parts = [
        cut_gate.ticks(
            [one[e] for one, e in zip(due, early, strict=True)],
            [one[e] for one, e in zip(ones, early, strict=True)],
            cut,
        )
    ]
    settled_ns = cut_gate.settled_ns
    parts.append(
        cut_gate.ticks(
            [one[~e] for one, e in zip(due, early, strict=True)],
            [one[~e] for one, e in zip(ones, early, strict=True)],
        )
    )
    assert (parts[1].due_ns > min(settled_ns, cut - 1)).all()
    assert np.concatenate([part.due_ns for part in parts]).tolist() == whole.due_ns.tolist()
    assert np.concatenate([part.steps for part in parts]).tolist() == whole.steps.tolist()
