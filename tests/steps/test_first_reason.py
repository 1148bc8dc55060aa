"""A stop: its first reason stays, and it shows only when the switched outputs are safe."""

from __future__ import annotations

import pytest

from deltactl.drivers.fakes.bench import simulated_step_output
from deltactl.drivers.settings import InputSettings, StepSettings
from deltactl.drivers.steps import board as b
from deltactl.drivers.steps.lines import OUTPUT_LINES, SWITCH_SHIFT
from deltactl.drivers.steps.player import PlayerSettings, PulsePlayer
from deltactl.foundation.clock import VirtualClock, sleep_s

GRIPPER, BRAKE = 1 << SWITCH_SHIFT, 2 << SWITCH_SHIFT
SETTINGS = PlayerSettings(
    pulse_width_ns=5_000,
    direction_setup_ns=5_000,
    minimum_gap_fraction=0.9,
    heartbeat_ns=10**12,
    inverted=0,
    enable_level=1,
    input_mask=0,
    input_idle=0,
    poll_ns=1_000_000,
    switch_mask=GRIPPER | BRAKE,
    switch_safe=BRAKE,
)


class SlowLines:
    """Lines on which somebody reads the board while they are written; `broken` refuses writes."""

    def __init__(self, board: b.Board) -> None:
        self._words = board.words
        self.levels = 0
        self.seen: list[int] = []
        self.broken = False

    def write(self, levels: int, mask: int) -> None:
        if mask >> OUTPUT_LINES:
            self.seen.append(self._words[b.STATE])
            if self.broken:
                raise OSError("no such line")
        self.levels = self.levels & ~mask | levels & mask

    def read(self) -> int:
        return 0

    def close(self) -> None:
        pass


def enabled() -> tuple[b.Board, SlowLines, PulsePlayer]:
    """A player with its drives enabled and the gripper on."""
    board = b.Board(bytearray(b.BOARD_BYTES))
    lines = SlowLines(board)
    player = PulsePlayer(board, lines, SETTINGS, lambda: 0)
    for kind in (b.ENABLE, b.SWITCH):
        board.words[b.KIND] = kind
        board.words[b.ARGUMENTS], board.words[b.ARGUMENTS + 1] = GRIPPER, GRIPPER | BRAKE
        board.words[b.COMMAND] += 1
        player.serve()
    assert lines.levels & (GRIPPER | BRAKE) == GRIPPER
    lines.seen.clear()
    return board, lines, player


def test_stopped_is_shown_when_the_outputs_are_safe() -> None:
    board, lines, player = enabled()
    board.words[b.STOP] += 1
    player.serve()
    assert lines.seen == [b.READY]
    assert board.words[b.STATE] == b.STOPPED
    assert lines.levels & (GRIPPER | BRAKE) == BRAKE


def test_stopped_is_shown_when_the_lines_fail() -> None:
    board, lines, player = enabled()
    lines.broken = True
    board.words[b.STOP] += 1
    with pytest.raises(OSError, match="no such line"):
        player.serve()
    assert board.words[b.STATE] == b.STOPPED
    assert board.words[b.REASON] == b.REQUESTED
    player.stop(b.LINE_FAULT)
    assert board.words[b.REASON] == b.REQUESTED


def test_the_reason_is_that_of_the_first_stop() -> None:
    clock = VirtualClock()
    made = simulated_step_output(StepSettings(), InputSettings(), clock, realtime=False)
    made.output.enable()
    made.output.stop("first")
    made.output.stop("second")
    assert made.output.status().reason == "first"
    made.bench.press_estop()
    sleep_s(clock, 0.05)
    assert made.output.status().reason == "first"
    made.bench.release_estop()
    made.output.acknowledge()
    made.output.stop("third")
    assert made.output.status().reason == "third"
    made.close()
