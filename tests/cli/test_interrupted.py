"""Ctrl-C in a command that is at work: it ends, says so, and has the status that shells give it."""

from __future__ import annotations

import signal
import subprocess
import time
from pathlib import Path

from tests.rigs.started import started

ATTEMPTS, PATIENCE_S = 3, 20.0
"""Python drops an interrupt that comes in a finaliser; whoever meets that presses Ctrl-C again."""


def _interrupted(folder: Path, begun: str, *arguments: str) -> tuple[int, str]:
    """Status and standard error of a command interrupted once the file `begun` is there."""
    run = started(*arguments, cwd=folder)
    while not list(folder.glob(begun)):
        assert run.poll() is None
        time.sleep(0.02)
    time.sleep(0.3)
    for _ in range(ATTEMPTS):
        run.send_signal(signal.SIGINT)
        try:
            said = run.communicate(timeout=PATIENCE_S)[1]
            return run.wait(), said
        except subprocess.TimeoutExpired:
            continue
    run.kill()
    raise AssertionError(f"it goes on: {run.communicate()[1]}")


def test_a_command_that_computes_says_that_it_was_interrupted(tmp_path: Path) -> None:
    collect = (
        "network",
        "collect",
        "--as-built",
        "zhao-2023",
        "--samples",
        "5000",
        "--out",
        "data",
    )
    status, said = _interrupted(tmp_path, "data/*", *collect)
    assert status == 130
    assert said.splitlines()[-1] == "deltactl: interrupted"
    assert "Traceback" not in said


def test_a_survey_on_the_simulated_robot_ends_and_keeps_what_it_has(tmp_path: Path) -> None:
    """On the virtual clock the robot's loops run within the wait: a signal must not end them."""
    collect = ("network", "collect", "--simulate", "--samples", "5000", "--out", "data")
    status, said = _interrupted(tmp_path, "data/*.mcap", *collect)
    assert status == 2
    assert "did not run to its end (cancelled)" in said
