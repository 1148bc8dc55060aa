"""The player against any schedule, any delay and any interruption: what must hold always."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from deltactl.drivers.steps import board as b
from deltactl.drivers.steps.contract import Ticks
from deltactl.drivers.steps.lines import (
    DIRECTION_BITS,
    DIRECTION_SHIFT,
    ENABLE_BIT,
    STEP_BITS,
)
from deltactl.drivers.steps.output import as_ticks
from deltactl.drivers.steps.player import PlayerSettings, PulsePlayer

FRACTION = 0.9
SETTINGS = PlayerSettings(
    pulse_width_ns=5_000,
    direction_setup_ns=5_000,
    minimum_gap_fraction=FRACTION,
    heartbeat_ns=10**12,
    inverted=0b010,
    enable_level=1,
    input_mask=0b1111,
    input_idle=0b1110,
    poll_ns=1_000_000,
)


@dataclass
class Recorder:
    """Lines that remember every change, and time that passes while they are written."""

    now_ns: int = 0
    levels: int = 0
    inputs: int = SETTINGS.input_idle
    rises: list[tuple[int, int, int]] = field(default_factory=list)
    """(time, STEP bits, DIR bits)"""
    falls: list[tuple[int, int]] = field(default_factory=list)
    turns: list[tuple[int, int]] = field(default_factory=list)

    def write(self, levels: int, mask: int) -> None:
        changed = (self.levels ^ levels) & mask
        self.levels ^= changed
        if changed & self.levels & STEP_BITS:
            directions = (self.levels & DIRECTION_BITS) >> DIRECTION_SHIFT
            self.rises.append((self.now_ns, changed & STEP_BITS, directions))
        elif changed & STEP_BITS:
            self.falls.append((self.now_ns, changed & STEP_BITS))
        if changed & DIRECTION_BITS:
            self.turns.append((self.now_ns, (changed & DIRECTION_BITS) >> DIRECTION_SHIFT))

    def read(self) -> int:
        return self.inputs

    def close(self) -> None:
        pass

    def counted(self) -> list[int]:
        """What drives would have counted, motor 2 being mounted the other way round."""
        counts = [0, 0, 0]
        for _, stepped, directions in self.rises:
            for motor in range(3):
                if stepped >> motor & 1:
                    high = (directions ^ SETTINGS.inverted) >> motor & 1
                    counts[motor] += 1 if high else -1
        return counts


class Player:
    """A player on recorded lines, with delays injected wherever it waits."""

    def __init__(self, ahead_ns: int = 0) -> None:
        settings = SETTINGS._replace(check_ahead_ns=ahead_ns)
        self.board = b.Board(bytearray(b.BOARD_BYTES))
        self.lines = Recorder()
        self.player = PulsePlayer(self.board, self.lines, settings, lambda: self.lines.now_ns)
        self.ask(b.ENABLE)

    def ask(self, kind: int) -> int:
        words = self.board.words
        words[b.KIND] = kind
        words[b.COMMAND] += 1
        self.player.serve()
        return words[b.RESULT]

    def push(self, ticks: Ticks) -> None:
        due_ns, codes = as_ticks(ticks)
        for index, (due, code) in enumerate(zip(due_ns, codes, strict=True)):
            slot = (self.board.words[b.PUSHED] + index) & b.SLOT_MASK
            self.board.due_ns[slot], self.board.codes[slot] = int(due), int(code)
        self.board.words[b.PUSHED] += len(due_ns)

    def play(self, delays_ns: list[int], until_ns: int = 10**15) -> None:
        """Play; each wake-up is late by the next delay. Leaves off when the time has come."""
        for turn, wake_ns in enumerate(self.player.play()):
            if max(wake_ns, self.lines.now_ns) > until_ns:
                self.lines.now_ns = until_ns
                return
            late_ns = delays_ns[turn % len(delays_ns)] if delays_ns else 0
            self.lines.now_ns = max(self.lines.now_ns, wake_ns) + late_ns

    def counts(self) -> list[int]:
        return list(self.board.words[b.COUNTS : b.COUNTS + 3])


GAP = st.integers(50_000, 3_000_000)
STEP = st.tuples(*[st.sampled_from((-1, 0, 1))] * 3)
DELAY = st.one_of(st.integers(0, 20_000), st.integers(0, 20_000_000))
SCHEDULE = st.lists(st.tuples(GAP, STEP), min_size=1, max_size=40)
DELAYS = st.lists(DELAY, max_size=30)
AHEAD = st.sampled_from((0, 60_000))


def ticks_of(schedule: list[tuple[int, tuple[int, ...]]], start_ns: int) -> Ticks:
    due_ns = start_ns + np.cumsum([gap for gap, _ in schedule])
    return Ticks(due_ns, np.array([steps for _, steps in schedule], dtype=np.int8))


@given(SCHEDULE, DELAYS, AHEAD)
def test_every_step_comes_out_once_in_order_and_is_counted(schedule, delays, ahead_ns) -> None:
    rig = Player(ahead_ns)
    ticks = ticks_of(schedule, 1_000_000)
    rig.push(ticks)
    rig.play(delays)
    moving = [row for row in ticks.steps.tolist() if any(row)]
    assert len(rig.lines.rises) == len(moving)
    for (_, stepped, _), row in zip(rig.lines.rises, moving, strict=True):
        assert [stepped >> motor & 1 for motor in range(3)] == [abs(step) for step in row]
    assert rig.counts() == rig.lines.counted() == ticks.steps.sum(axis=0).tolist()
    assert rig.board.words[b.STATE] == b.READY
    assert not rig.lines.levels & STEP_BITS


@given(SCHEDULE, DELAYS, AHEAD)
def test_no_two_steps_are_closer_than_planned_whatever_the_delays(
    schedule, delays, ahead_ns
) -> None:
    rig = Player(ahead_ns)
    ticks = ticks_of(schedule, 1_000_000)
    rig.push(ticks)
    rig.play(delays)
    planned_ns = np.diff(ticks.due_ns[(ticks.steps != 0).any(axis=1)])
    real_ns = np.diff([t_ns for t_ns, _, _ in rig.lines.rises])
    assert (real_ns >= np.floor(FRACTION * planned_ns)).all()


@given(SCHEDULE, DELAYS, AHEAD)
def test_nothing_is_early_and_what_slips_is_said(schedule, delays, ahead_ns) -> None:
    rig = Player(ahead_ns)
    ticks = ticks_of(schedule, 1_000_000)
    rig.push(ticks)
    rig.play(delays)
    due_ns = ticks.due_ns[(ticks.steps != 0).any(axis=1)]
    real_ns = np.array([t_ns for t_ns, _, _ in rig.lines.rises])
    assert (real_ns >= due_ns).all()
    if not any(delays):
        assert (real_ns == due_ns).all()
        assert rig.board.words[b.SLIP] == 0


@given(SCHEDULE, DELAYS, AHEAD)
def test_pulse_width_pause_and_direction_set_up_hold(schedule, delays, ahead_ns) -> None:
    rig = Player(ahead_ns)
    rig.push(ticks_of(schedule, 1_000_000))
    rig.play(delays)
    lines = rig.lines
    for (rose_ns, up, _), (fell_ns, down) in zip(lines.rises, lines.falls, strict=True):
        assert up == down
        assert fell_ns - rose_ns >= SETTINGS.pulse_width_ns
    pauses = zip(lines.falls, lines.rises[1:], strict=False)
    assert all(rise[0] - fall[0] >= SETTINGS.pulse_width_ns for fall, rise in pauses)
    for turned_ns, motors in lines.turns:
        later = [t for t, stepped, _ in lines.rises if stepped & motors and t >= turned_ns]
        assert not later or later[0] - turned_ns >= SETTINGS.direction_setup_ns
        assert not any(
            rise <= turned_ns < fall
            for (rise, *_), (fall, _) in zip(lines.rises, lines.falls, strict=True)
        )


@given(
    SCHEDULE, DELAYS, st.integers(0, 60_000_000), st.sampled_from(["stop", "estop", "alarm"]), AHEAD
)
def test_after_a_stop_there_is_no_edge(schedule, delays, stop_ns, how, ahead_ns) -> None:
    rig = Player(ahead_ns)
    rig.push(ticks_of(schedule, 1_000_000))
    rig.play(delays, until_ns=stop_ns)
    before = len(rig.lines.rises)
    if how == "stop":
        rig.board.words[b.STOP] += 1
    else:
        rig.lines.inputs = 0b1111 if how == "estop" else 0b1010
    rig.play(delays)
    rig.player.serve()
    assert len(rig.lines.rises) == before
    assert rig.board.words[b.STATE] == b.STOPPED
    assert rig.board.words[b.PUSHED] == rig.board.words[b.PLAYED]
    assert rig.counts() == rig.lines.counted()
    expected = {"stop": b.REQUESTED, "estop": b.BY_ESTOP, "alarm": b.BY_ALARM + 2}
    assert rig.board.words[b.REASON] == expected[how]


@pytest.mark.study
@given(SCHEDULE, SCHEDULE, DELAYS, AHEAD)
def test_a_second_run_is_on_time_whatever_slipped_in_the_first(
    first, second, delays, ahead_ns
) -> None:
    rig = Player(ahead_ns)
    rig.push(ticks_of(first, 1_000_000))
    rig.play(delays)
    slip_ns = rig.board.words[b.SLIP]
    later = ticks_of(second, rig.lines.now_ns + 100_000_000)
    rig.push(later)
    seen = len(rig.lines.rises)
    rig.play([])
    moving = (later.steps != 0).any(axis=1)
    assert [t for t, _, _ in rig.lines.rises[seen:]] == later.due_ns[moving].tolist()
    assert rig.board.words[b.SLIP] == slip_ns


@pytest.mark.study
@given(SCHEDULE, SCHEDULE, DELAYS, AHEAD, st.integers(-3_000_000, 3_000_000))
def test_a_second_run_that_is_due_at_once_begins_no_faster_than_the_first_ended(
    first, second, delays, ahead_ns, pause_ns
) -> None:
    """The first ended late, and the second may be due before that: its first gap is bounded."""
    rig = Player(ahead_ns)
    ticks = ticks_of(first, 1_000_000)
    ended_ns = ticks.due_ns[(ticks.steps != 0).any(axis=1)]
    later = ticks_of(second, int(ended_ns[-1]) + pause_ns if len(ended_ns) else 0)
    begins_ns = later.due_ns[(later.steps != 0).any(axis=1)]
    assume(len(ended_ns) >= 2 and len(begins_ns) >= 1)
    rig.push(ticks)
    rig.play(delays)
    seen = len(rig.lines.rises)
    rig.push(later)
    rig.play([])
    gap_ns, last_gap_ns = begins_ns[0] - ended_ns[-1], ended_ns[-1] - ended_ns[-2]
    least_ns = min(gap_ns, last_gap_ns) if gap_ns > 0 else last_gap_ns
    real_ns = rig.lines.rises[seen][0] - rig.lines.rises[seen - 1][0]
    assert real_ns >= np.floor(FRACTION * least_ns)


def test_the_first_reason_of_a_stop_stays() -> None:
    rig = Player()
    rig.player.stop(b.BY_ESTOP)
    rig.player.stop(b.REQUESTED)
    rig.player.stop(b.NO_HEARTBEAT)
    assert rig.board.words[b.REASON] == b.BY_ESTOP
    assert rig.board.reason_text() == "e-stop"
    assert rig.ask(b.ACKNOWLEDGE) == b.DONE
    rig.player.stop(b.REQUESTED)
    assert rig.board.words[b.REASON] == b.REQUESTED


def test_what_was_queued_before_a_stop_is_never_played_after_it() -> None:
    rig = Player()
    rig.push(ticks_of([(100_000, (1, 1, 1))] * 10, 0))
    playing = rig.player.play()
    wake_ns = next(playing)
    rig.player.stop(b.REQUESTED)
    assert rig.ask(b.ACKNOWLEDGE) == b.DONE
    assert rig.ask(b.ENABLE) == b.DONE
    rig.push(ticks_of([(100_000, (-1, 0, 0))] * 2, wake_ns + 1_000_000))
    for wake_ns in playing:
        rig.lines.now_ns = max(rig.lines.now_ns, wake_ns)
    assert rig.counts() == rig.lines.counted() == [-2, 0, 0]


def test_enable_level_and_mirrored_motor_reach_the_lines() -> None:
    rig = Player()
    assert rig.lines.levels & ENABLE_BIT
    rig.push(ticks_of([(100_000, (1, 1, -1))], 0))
    rig.play([])
    assert rig.lines.rises[0][1:] == (0b111, 0b001)


def test_ticks_that_came_in_while_it_stopped_are_dropped_with_the_stop() -> None:
    """Its state was looked at before the stop, and the ticks were written after it."""
    rig = Player()
    rig.player.stop(b.REQUESTED)
    rig.push(ticks_of([(100_000, (1, 1, 1))] * 3, 0))
    assert rig.ask(b.ACKNOWLEDGE) == b.DONE
    assert rig.ask(b.ENABLE) == b.DONE
    rig.play([])
    assert rig.lines.rises == []


class Fences:
    """Stands in for a fence; notes what the other side may see at each."""

    def __init__(self, words: memoryview):
        self.words = words
        self.seen: list[tuple[int, ...]] = []

    def __call__(self) -> None:
        self.seen.append(tuple(self.words[i] for i in (b.VERSION, b.COUNTS, b.PLAYED)))


def test_memory_is_ordered_wherever_the_other_side_may_look(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """No test on a PC shows what an ARM core may reorder, so here is where the fences are."""
    rig = Player()
    fence = Fences(rig.board.words)
    monkeypatch.setattr(rig.player, "_fence", fence)
    rig.push(ticks_of([(100_000, (1, 0, 0))], 0))
    rig.play([])
    # Before the tick is read; after the counters are marked; after they and the edge are written.
    assert fence.seen == [(0, 0, 0), (1, 0, 0), (1, 1, 0)]
    fence.seen.clear()
    rig.board.words[b.ARGUMENTS] = 7
    assert rig.ask(b.SET_COUNTS) == b.DONE
    # Before the request is read, round the counters, and before it is said to be served.
    assert fence.seen == [(2, 1, 1), (3, 1, 1), (3, 7, 1), (4, 7, 1)]
    fence.seen.clear()
    rig.push(ticks_of([(100_000, (1, 0, 0))], rig.lines.now_ns))
    rig.player.stop(b.REQUESTED)
    # Before what was queued is dropped, and before it is said to be played.
    assert fence.seen == [(4, 7, 1), (4, 7, 1)]
