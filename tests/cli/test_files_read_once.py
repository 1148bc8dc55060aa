"""A run opens each of its files once, checks it once, and loads its network once."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

import deltactl
from deltactl.firmware_py.daemon.client import Client
from deltactl.firmware_py.named_files import CONFIG_FOLDER, TRAINED_FOLDER
from tests.rigs.large_requests import daemon

COUNTED = """
import json, os, sys
opened, made = {}, []

def hook(event, arguments):
    if event == "open" and isinstance(arguments[0], (str, bytes, os.PathLike)):
        name = os.fsdecode(arguments[0])
        opened[name] = opened.get(name, 0) + 1

sys.addaudithook(hook)
try:
    import tflite_runtime.interpreter as runtime
except ImportError:
    import ai_edge_litert.interpreter as runtime
interpreter = runtime.Interpreter

class Counted(interpreter):
    def __init__(self, *given, **named):
        made.append(1)
        super().__init__(*given, **named)

runtime.Interpreter = Counted
from deltactl.cli.main import app
try:
    app(sys.argv[2:])
finally:
    with open(sys.argv[1], "w") as out:
        json.dump({"opened": opened, "interpreters": len(made)}, out)
"""
"""A command as a process of its own, and what it has opened and loaded."""


LINE = "{shape: straight, to_m: [0.0, 0.01, -0.45]}"
TIMING = "timing: {mode: accelerated, speed_mps: 0.1}\n"
NETWORK = "inverse_kinematics: {kind: network, file: zhao-2023.tflite}\n"


def counted(folder: Path, words: Sequence[str]) -> tuple[dict[str, int], int]:
    """How often each file was opened, and how many interpreters were made."""
    out = folder / "counted.json"
    done = subprocess.run(
        [sys.executable, "-c", COUNTED, str(out), *words],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(Path(deltactl.__file__).parents[1])},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    found = json.loads(out.read_text())
    opened: dict[str, int] = {}
    for name, count in found["opened"].items():
        place = str((folder / name).resolve())
        opened[place] = opened.get(place, 0) + count
    return opened, found["interpreters"]


def times(opened: dict[str, int], file: Path) -> int:
    """Openings of a file by whatever path."""
    return opened.get(str(file.resolve()), 0)


@pytest.mark.study
def test_a_simulated_run_of_a_robot_that_is_named_twice(tmp_path: Path) -> None:
    job = tmp_path / "short.yaml"
    job.write_text(f"name: short\nrobot: zhao-2023.yaml\n{TIMING}{NETWORK}path: {LINE}\n")
    words = ["run", "short.yaml", "--simulate", "--json", "--robot", "zhao-2023.yaml"]
    opened, interpreters = counted(tmp_path, words)
    assert times(opened, job) == 1
    assert times(opened, CONFIG_FOLDER / "zhao-2023.yaml") == 1
    assert times(opened, TRAINED_FOLDER / "zhao-2023.tflite") == 1
    assert interpreters == 1


@pytest.mark.study
def test_a_job_with_steps_and_an_included_one(tmp_path: Path) -> None:
    robot = (CONFIG_FOLDER / "zhao-2023.yaml").read_text()
    (tmp_path / "robot.yaml").write_text(robot)
    (tmp_path / "inner.yaml").write_text(
        f"name: inner\nrobot: robot.yaml\n{TIMING}{NETWORK}path: {LINE}\n"
    )
    (tmp_path / "outer.yaml").write_text(
        f"name: outer\nrobot: robot.yaml\n{TIMING}{NETWORK}"
        f"steps: [{{include: inner.yaml}}, {{path: {LINE}}}, {{include: inner.yaml}}]\n"
    )
    opened, interpreters = counted(tmp_path, ["run", "outer.yaml", "--simulate", "--json"])
    for name in ("outer.yaml", "inner.yaml", "robot.yaml"):
        assert times(opened, tmp_path / name) == 1, name
    assert times(opened, TRAINED_FOLDER / "zhao-2023.tflite") == 1
    assert interpreters == 1


@pytest.mark.study
@pytest.mark.realtime
def test_the_client_of_a_daemon(tmp_path: Path) -> None:
    """It needs no interpreter: the daemon moves the robot."""
    with daemon(tmp_path) as socket:
        with Client(socket) as client:
            client.power_on()
            client.home(360.0)
        opened, interpreters = counted(
            tmp_path, ["run", "heart.yaml", "--socket", str(socket), "--detach"]
        )
    assert times(opened, CONFIG_FOLDER / "heart.yaml") == 1
    assert times(opened, CONFIG_FOLDER / "zhao-2023.yaml") <= 1
    assert interpreters == 0
