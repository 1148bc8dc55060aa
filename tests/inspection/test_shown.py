"""What `inspect` prints: in a window no wider than it, elsewhere one line for each sentence."""

from __future__ import annotations

import os
import pty
import shlex
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from deltactl.foundation.one_screen import LINES
from tests.inspection.logs_of_makers import T_S, asked, current, seen

Deltactl = Callable[..., subprocess.CompletedProcess[str]]
HEAD = "ms,axis_of_the_gantry_goal,axis_of_the_gantry_present,torque_Nm,axis_of_the_gantry_speed"


def write(path: Path) -> None:
    parts = [1e3 * T_S, 40.0 * asked(), 40.0 * seen(), current(), 40.0 * np.gradient(seen(), T_S)]
    np.savetxt(path, np.stack(parts, axis=1), "%.5f", ",", header=HEAD, comments="")


def in_a_window(folder: Path, width: int, *arguments: str) -> str:
    """What the program prints where it sees a terminal of that width."""
    seen_by, shown_on = pty.openpty()
    environment = os.environ | {"COLUMNS": str(width), "TERM": "dumb", "NO_COLOR": "1"}
    with subprocess.Popen(
        [sys.executable, "-m", "deltactl.cli.main", *arguments],
        cwd=folder, env=environment, stdout=shown_on, stderr=shown_on, stdin=shown_on,
    ) as program:  # fmt: skip
        os.close(shown_on)
        text = b""
        try:
            while part := os.read(seen_by, 4096):
                text += part
        except OSError:  # the other end is closed
            pass
        assert program.wait() == 0
    os.close(seen_by)
    return text.decode().replace("\r\n", "\n")


@pytest.mark.study
def test_nothing_is_broken_at_the_edge_of_a_window(tmp_path: Path) -> None:
    width = 80
    write(tmp_path / "log.csv")
    shown = in_a_window(tmp_path, width, "inspect", "log.csv")
    assert max(map(len, shown.splitlines())) <= width
    command = shlex.split(shown[shown.index("deltactl diagnose") :])
    assert command[:5] == ["deltactl", "diagnose", "log.csv", "--robot", "log-robot.yaml"]
    assert {"unit=UNIT", "command=axis_of_the_gantry_goal"} <= {*command}
    assert "of a weight or a spring only --set load=torque_Nm" in " ".join(shown.split())
    assert len(shown.splitlines()) <= LINES


def test_elsewhere_every_sentence_and_command_is_one_line(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    write(tmp_path / "log.csv")
    done = deltactl("inspect", "log.csv")
    assert done.stderr == ""
    lines = done.stdout.splitlines()
    (load,) = [line for line in lines if "to use the effort too" in line]
    assert load.endswith("only --set load=torque_Nm)")
    (command,) = [line for line in lines if line.startswith("diagnose it:")]
    assert command.endswith("--set velocity=axis_of_the_gantry_speed")


def test_large_numbers_stand_without_a_power_of_ten(deltactl: Deltactl, tmp_path: Path) -> None:
    rows = [f"{t:.2f},{1e6 * q:.1f},{1e6 * q - 5.0:.1f}" for t, q in zip(T_S, asked(), strict=True)]
    (tmp_path / "um.csv").write_text("\n".join(["time,goal_um,laser_um", *rows]) + "\n")
    done = deltactl("inspect", "um.csv")
    assert "e+0" not in done.stdout


def test_names_that_take_two_lines_leave_the_answer_on_one_screen(tmp_path: Path) -> None:
    t_s = 0.01 * np.arange(2000)
    asked = 0.8 * np.sin(0.7 * t_s) + 0.2 * np.sin(2.3 * t_s)
    read = np.interp(t_s - 0.03, t_s, asked)
    columns = {
        "__time": 1.7e9 + t_s,
        "/left_arm_controller/state/reference/positions[0]": asked,
        "/left_arm_controller/state/feedback/positions[0]": read,
        "/left_arm_controller/state/feedback/velocities[0]": np.gradient(read, t_s),
        "/left_arm_controller/state/error/positions[0]": asked - read,
    }
    rows = np.stack([*columns.values()], axis=1)
    np.savetxt(tmp_path / "a.csv", rows, "%.6f", ",", header=",".join(columns), comments="")
    shown = in_a_window(tmp_path, 80, "inspect", "a.csv")
    assert len(shown.rstrip("\n").splitlines()) <= LINES
    assert "positions[0]" in shown
