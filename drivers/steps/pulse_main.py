"""The pulse process: `python -m deltactl.drivers.steps.pulse_main CONFIG`.

Started by process_host.py.
Owns lines and counters; ends with its controller, STEP low. Imports as little as it can.
"""

from __future__ import annotations

import json
import os
import signal
import sys
from importlib import import_module
from mmap import mmap
from time import monotonic_ns, sleep
from typing import Any

from deltactl.drivers.steps import board as b
from deltactl.drivers.steps.lines import LineGroup
from deltactl.drivers.steps.player import PulsePlayer
from deltactl.drivers.steps.realtime import become_punctual, die_with_parent, doze_until, wait_until
from deltactl.drivers.steps.timing import PlayerSettings

IDLE_S = 0.001
"""While nothing is to be played, inputs and requests are looked at this often."""


def open_lines(config: dict[str, Any]) -> LineGroup:
    """The line group that the controller named, as 'module:function' of the whole config.

    The lines of a fake bench are such a module too: this one need not know it.
    """
    module, _, function = config["lines"].partition(":")
    opened: LineGroup = getattr(import_module(module), function)(config)
    return opened


def watch_controller(words: memoryview, controller: int) -> None:
    """End when the controller does. A SIGTERM while it lives is its own affair, not ours."""

    def on_signal(*_: object) -> None:
        if os.getppid() != controller:
            words[b.CLOSE] = b.CONTROLLER_GONE

    for terminal in (signal.SIGINT, signal.SIGHUP):  # sent to the whole group
        signal.signal(terminal, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, on_signal)
    die_with_parent(signal.SIGTERM)
    on_signal()  # it may have ended before we asked to be told


def remove_folder() -> None:
    """Nobody else is left to remove the folder we were started in."""
    from shutil import rmtree

    folder = os.getcwd()
    if os.path.basename(folder).startswith("deltactl-pulses-"):  # not one started by hand
        rmtree(folder, ignore_errors=True)


def run(player: PulsePlayer, words: memoryview) -> None:
    """Serve and play until told to close."""
    while not words[b.CLOSE]:
        for wake_ns in player.play():
            if player.near_edge:
                wait_until(wake_ns)
            else:
                doze_until(wake_ns)
        player.serve()
        if not player.pending:
            sleep(IDLE_S)


def main(arguments: list[str]) -> int:
    """Exit status 0 when told to end, 1 when the lines failed (the board says how)."""
    config = json.loads(arguments[0])
    board = b.Board(mmap(config["board"], b.BOARD_BYTES))
    words = board.words
    watch_controller(words, config["controller"])
    try:
        lines = open_lines(config)
        words[b.REALTIME] = become_punctual()
        player = PulsePlayer(board, lines, PlayerSettings(*config["settings"]), monotonic_ns)
    except OSError as error:
        board.set_fault(str(error))
        return 1
    try:
        run(player, words)
        player.make_safe(words[b.CLOSE])
        lines.close()
        if words[b.CLOSE] == b.CONTROLLER_GONE:
            remove_folder()
    except OSError as error:
        board.set_fault(str(error))
        player.stop(b.LINE_FAULT)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
