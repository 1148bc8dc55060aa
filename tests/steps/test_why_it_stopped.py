"""What a stop is said to be for, and where ticks may go on."""

from __future__ import annotations

import numpy as np
import pytest

from deltactl.drivers.fakes.bench import simulated_step_output
from deltactl.drivers.settings import InputSettings, StepSettings
from deltactl.drivers.steps.board import (
    ALL_MOTORS,
    BOARD_BYTES,
    BY_ALARM,
    LINE_FAULT,
    REASON,
    REQUESTED,
    TEXT_BYTES,
    Board,
)
from deltactl.drivers.steps.contract import Ticks
from deltactl.foundation.clock import VirtualClock


@pytest.mark.parametrize("motor", [1, 2, 3])
def test_an_alarm_names_its_motor(motor: int) -> None:
    board = Board(bytearray(BOARD_BYTES))
    board.words[REASON] = BY_ALARM + motor
    assert board.reason_text() == f"alarm motor{motor}"
    board.words[REASON] = BY_ALARM + ALL_MOTORS
    assert "all three motors at once" in board.reason_text()


def test_what_the_lines_said_and_what_was_asked_for_are_kept_apart() -> None:
    board = Board(bytearray(BOARD_BYTES))
    board.set_request("somebody stands in the way")
    board.set_fault("the wire burned through")
    board.words[REASON] = LINE_FAULT
    assert board.reason_text() == "the wire burned through"
    board.words[REASON] = REQUESTED
    assert board.reason_text() == "somebody stands in the way"
    board.set_fault("x" * 1000)
    assert board.fault() == "x" * TEXT_BYTES
    assert board.request() == "somebody stands in the way"


def test_the_words_of_a_request_are_kept() -> None:
    clock = VirtualClock()
    made = simulated_step_output(StepSettings(), InputSettings(), clock, realtime=False)
    made.output.enable()
    made.output.stop("somebody stands in the way")
    assert made.output.status().reason == "somebody stands in the way"
    made.close()
    assert REQUESTED > 0


def test_ticks_follow_the_last_ones_not_the_first() -> None:
    clock = VirtualClock()
    made = simulated_step_output(StepSettings(), InputSettings(), clock, realtime=False)
    made.output.enable()
    start_ns = clock.now_ns() + 100_000_000
    due_ns = start_ns + 10_000_000 * np.arange(4)
    made.output.push(Ticks(due_ns, np.ones((4, 3), np.int8)))
    between = np.array([due_ns[1] + 12_000_000])
    with pytest.raises(ValueError, match="strictly increasing"):
        made.output.push(Ticks(between, np.ones((1, 3), np.int8)))
    made.close()
