"""Where no daemon answers, what to type names the robot files that are in the folder."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

Deltactl = Callable[..., subprocess.CompletedProcess[str]]
ROBOT = Path(__file__).parents[2] / "config" / "zhao-2023.yaml"


def test_the_files_that_are_here(deltactl: Deltactl, tmp_path: Path) -> None:
    socket = ("--socket", str(tmp_path / "none.sock"))
    assert (
        "'deltactl service daemon zhao-2023.yaml --simulate'"
        in deltactl("home", *socket, status=2).stderr
    )
    (tmp_path / "job.yaml").write_text("name: job\nrobot: mine.yaml\n")
    (tmp_path / "axis.yaml").write_text("kind: servo_axis\nname: axis\nmotion: linear\n")
    (tmp_path / "mine.yaml").write_text(ROBOT.read_text())
    assert (
        "with 'deltactl service daemon mine.yaml --simulate'"
        in deltactl("home", *socket, status=2).stderr
    )
    goto = ("goto", "0", "0", "-450", *socket)
    assert "add --robot mine.yaml" in deltactl(*goto, status=2).stderr
    (tmp_path / "second.yaml").write_text(ROBOT.read_text())
    assert "add --robot mine.yaml or --robot second.yaml" in deltactl(*goto, status=2).stderr
    said = deltactl("home", *socket, status=2).stderr
    assert (
        "'deltactl service daemon mine.yaml --simulate' or 'deltactl service daemon second.yaml"
        in said
    )


@pytest.mark.study
def test_without_robot_the_one_of_the_folder_is_taken_and_said(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    no_daemon = ("--socket", str(tmp_path / "none.sock"))
    taken = "Robot file: zhao-2023.yaml, the example; --robot names another."
    assert taken in deltactl("service", "install").stderr
    mine = ROBOT.read_text().replace("name: zhao-2023", "name: mine")
    assert mine != ROBOT.read_text()
    (tmp_path / "mine.yaml").write_text(mine)
    said = "Robot file: mine.yaml, the one in this folder."
    installed = deltactl("service", "install")
    assert said in installed.stderr
    assert "Wiring of 'mine'" in installed.stdout
    assert said in deltactl("status", "sensors", "--json", *no_daemon).stderr
    assert "Robot file" not in deltactl("service", "install", "--robot", "mine.yaml").stderr
    assert said not in deltactl("web", "foxglove", "--layout", "l.json").stderr


def test_of_several_none_is_taken(deltactl: Deltactl, tmp_path: Path) -> None:
    for name in ("mine.yaml", "second.yaml"):
        (tmp_path / name).write_text(ROBOT.read_text())
    no_daemon = ("--socket", str(tmp_path / "none.sock"))
    for typed in (
        ("network", "collect", "--simulate", "--samples", "3", "--out", "data"),
        ("status", "record", "still.mcap"),
        ("service", "install"),
        ("web", "--simulate"),
        ("web", "foxglove", *no_daemon),
        ("status", "sensors", *no_daemon),
    ):
        assert deltactl(*typed, status=2).stderr.splitlines() == [
            "deltactl: 2 robot files are in this folder; add --robot mine.yaml or"
            " --robot second.yaml"
        ], typed
    assert not (tmp_path / "still.mcap").exists()
