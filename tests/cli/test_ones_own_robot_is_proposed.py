"""Where no daemon answers, what to type names the robot files that are in the folder."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path

Deltactl = Callable[..., subprocess.CompletedProcess[str]]
ROBOT = Path(__file__).parents[2] / "config" / "zhao-2023.yaml"


def test_the_files_that_are_here(deltactl: Deltactl, tmp_path: Path) -> None:
    socket = ("--socket", str(tmp_path / "none.sock"))
    assert (
        "'deltactl daemon zhao-2023.yaml --simulate'" in deltactl("home", *socket, status=2).stderr
    )
    (tmp_path / "job.yaml").write_text("name: job\nrobot: mine.yaml\n")
    (tmp_path / "axis.yaml").write_text("kind: servo_axis\nname: axis\nmotion: linear\n")
    (tmp_path / "mine.yaml").write_text(ROBOT.read_text())
    assert (
        "with 'deltactl daemon mine.yaml --simulate'" in deltactl("home", *socket, status=2).stderr
    )
    goto = ("goto", "0", "0", "-450", *socket)
    assert "add --robot mine.yaml" in deltactl(*goto, status=2).stderr
    (tmp_path / "second.yaml").write_text(ROBOT.read_text())
    assert "add --robot mine.yaml or --robot second.yaml" in deltactl(*goto, status=2).stderr
    said = deltactl("home", *socket, status=2).stderr
    assert "'deltactl daemon mine.yaml --simulate' or 'deltactl daemon second.yaml" in said
