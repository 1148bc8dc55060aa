"""The feeder alone: it plays on only where the controller was awake."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from deltactl.drivers.steps.contract import Ticks
from deltactl.firmware_py.controller.jobs.feeder import LEAD_S, LOOKAHEAD_S, Feeder
from deltactl.firmware_py.controller.jobs.journal import Journal
from deltactl.firmware_py.planner.motion import NOTHING_REACHED, Chunk, Reached
from deltactl.firmware_py.planner.time_scaling import TimeScaledMotion
from deltactl.foundation.clock import VirtualClock, ns
from deltactl.foundation.errors import PulseFault

HEARTBEAT_NS = ns(0.25)
PERIOD_NS = 1_000_000


class Output:
    """What a feeder needs of a step output."""

    def __init__(self) -> None:
        self.pushed: list[Ticks] = []
        self.slip_ns = 0

    def status(self):
        from deltactl.drivers.steps.contract import OutputState, OutputStatus

        return OutputStatus(OutputState.READY, (0, 0, 0), 0, self.slip_ns)

    def push(self, ticks: Ticks) -> None:
        self.pushed.append(ticks)


class SlowClock(VirtualClock):
    """A clock that goes on while something is worked out."""

    hang_ns = 0

    def now_ns(self) -> int:
        self._now_ns += self.hang_ns
        return super().now_ns()


def chunks(count: int) -> Iterator[Chunk]:
    for number in range(count):
        due = np.array([number * PERIOD_NS])
        yield Chunk(Ticks(due, np.ones((1, 3), np.int8)), NOTHING_REACHED, (number + 1) * PERIOD_NS)


def feeder(clock: SlowClock, output: Output) -> Feeder:
    motion = TimeScaledMotion(chunks(1000), 0.2)
    return Feeder(output, Journal(), motion, clock, HEARTBEAT_NS)


def test_only_the_look_ahead_is_queued() -> None:
    clock, output = SlowClock(), Output()
    one = feeder(clock, output)
    one.feed(clock.now_ns())
    due_ns = np.concatenate([ticks.due_ns for ticks in output.pushed])
    assert due_ns[0] == ns(LEAD_S)
    assert ns(LOOKAHEAD_S) - 2 * PERIOD_NS <= due_ns[-1] <= ns(LOOKAHEAD_S)
    clock.sleep_until_ns(ns(0.05))
    one.feed(clock.now_ns())
    due_ns = np.concatenate([ticks.due_ns for ticks in output.pushed])
    assert ns(0.05 + LOOKAHEAD_S) - 2 * PERIOD_NS <= due_ns[-1] <= ns(0.05 + LOOKAHEAD_S)
    assert (np.diff(due_ns) == PERIOD_NS).all()


def test_what_was_worked_out_while_the_controller_hung_is_not_played() -> None:
    clock, output = SlowClock(), Output()
    one = feeder(clock, output)
    one.feed(clock.now_ns())
    before = len(output.pushed)
    clock.sleep_until_ns(ns(0.05))
    asked_ns = clock.now_ns()
    clock.hang_ns = HEARTBEAT_NS + 1
    with pytest.raises(PulseFault, match=r"no heartbeat: the controller hung for 0\.3 s"):
        one.feed(asked_ns)
    assert len(output.pushed) == before


def test_a_hang_shorter_than_the_heartbeat_is_none() -> None:
    clock, output = SlowClock(), Output()
    one = feeder(clock, output)
    asked_ns = clock.now_ns()
    clock.hang_ns = HEARTBEAT_NS // 2
    one.feed(asked_ns)
    assert output.pushed


def test_what_a_player_that_ran_dry_was_late_by_becomes_part_of_the_plan() -> None:
    """Late before this run: nothing. Late by 3 ms within it: ticks go out 3 ms later, once."""
    clock, output = SlowClock(), Output()
    output.slip_ns = 5_000_000
    one = feeder(clock, output)
    one.feed(clock.now_ns())
    first = output.pushed[0].due_ns[0]
    plain = output.pushed[-1].due_ns[-1]
    for slip_ns in (8_000_000, 8_000_000):
        output.slip_ns = slip_ns
        clock.sleep_until_ns(clock.now_ns() + ns(0.1))
        before = len(output.pushed)
        one.feed(clock.now_ns())
        assert output.pushed[before].due_ns[0] == plain + PERIOD_NS + 3_000_000
        plain = output.pushed[-1].due_ns[-1] - 3_000_000
    assert first < plain


def test_every_target_of_the_path_is_noted_and_none_of_the_way_there() -> None:
    """Numbers count from 0, as in the path file; what was reached is noted when it is due."""
    rows = np.array([-1, 0, 1])
    reached = Reached(
        index=rows + 1, number=rows, repeat=np.ones(3, np.int64), t_ns=PERIOD_NS * (rows + 1),
        position_m=np.arange(9.0).reshape(3, 3), angles_rad=np.zeros((3, 3)),
        counts=np.arange(9).reshape(3, 3), left=np.zeros(3, np.bool_),
    )  # fmt: skip
    noted: list[tuple[object, ...]] = []

    class Noting(Journal):
        def target(self, *row: object) -> None:
            noted.append(row)

    chunk = Chunk(Ticks(np.array([0]), np.ones((1, 3), np.int8)), reached, 4 * PERIOD_NS)
    clock = SlowClock()
    motion = TimeScaledMotion(iter([chunk]), 0.2)
    Feeder(Output(), Noting(), motion, clock, HEARTBEAT_NS).feed(clock.now_ns())  # type: ignore[arg-type]
    start_ns = ns(LEAD_S)
    assert noted == [
        (start_ns + PERIOD_NS, 0, (3.0, 4.0, 5.0), (3, 4, 5)),
        (start_ns + 2 * PERIOD_NS, 1, (6.0, 7.0, 8.0), (6, 7, 8)),
    ]
