"""`deltactl heal`: a robot with a hidden fault draws better afterwards, a healthy one is left alone.

Whenever the program is killed, the robot file that was in force is in force.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
import yaml

from deltactl.firmware_py.named_files import CONFIG_FOLDER

ROBOT = (CONFIG_FOLDER / "zhao-2023.yaml").read_text()
FAULT = {"effect": "home_offset", "component": "motor2", "parameters": {"angle": 0.012}}
HEART = {
    "name": "small-heart",
    "robot": "mine.yaml",
    "path": {"shape": "heart", "centre_m": [0.0, 0.0, -0.45], "width_m": 0.1},
    "timing": {"mode": "together", "t_pwm_s": 0.002},
    "inverse_kinematics": {"kind": "geometry"},
}
CALL = ("heal", "mine.yaml", "--job", "small.yaml", "--simulate", "--minutes", "0.5", "--json")
WAIT_S = 240.0


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "small.yaml").write_text(yaml.safe_dump(HEART))
    return tmp_path


def put_robot(folder: Path, *faults: dict[str, Any]) -> str:
    text = ROBOT + ("\n" + yaml.safe_dump({"as_built": {"effects": list(faults)}}))
    (folder / "mine.yaml").write_text(text)
    return text


def started(folder: Path, *words: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "deltactl.cli.main", *words]
    return subprocess.Popen(
        command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


def ran(folder: Path, *words: str, status: int = 0) -> dict[str, Any]:
    process = started(folder, *words)
    out, err = process.communicate(timeout=WAIT_S)
    assert process.returncode == status, err
    answer: dict[str, Any] = json.loads(out) if out else {"error": err}
    return answer


def killed_after(folder: Path, kinds: list[str], *words: str) -> None:
    """Begin, and kill the program as soon as recordings of these kinds are finished."""
    process, state = started(folder, *words), folder / "heal-mine" / "healing.json"
    give_up_s = time.monotonic() + WAIT_S
    while process.poll() is None and time.monotonic() < give_up_s:
        if state.exists() and (folder / "heal-mine" / "survey.yaml").exists():
            made = json.loads(state.read_text())["recordings"]
            if [one["kind"] for one in made] == kinds:
                break
        time.sleep(0.02)
    assert process.poll() is None, process.communicate()
    os.kill(process.pid, signal.SIGKILL)
    process.communicate()


def test_a_killed_healing_leaves_the_file_and_goes_on_and_is_undone(folder: Path) -> None:
    old = put_robot(folder, FAULT)
    robot_file = folder / "mine.yaml"
    go_on = (*CALL, "--continue")
    for kinds, call in (([], CALL), (["survey"], go_on), (["survey", "before"], go_on)):
        killed_after(folder, kinds, *call)
        assert robot_file.read_text() == old
    answer = ran(folder, *go_on)
    assert answer["outcome"] == "healed"
    assert answer["before_ci95_m"][0] > 2.0 * answer["after_rms_m"]
    assert answer["gain_ci95_m2"][0] > 0.0
    kinds = [Path(name).name.split("-")[0] for name in answer["recordings"]]
    assert kinds == ["survey", "before", "after"]
    (effect,) = yaml.safe_load(robot_file.read_text())["effects"]
    assert effect["effect"] == FAULT["effect"]
    assert effect["parameters"]["angle"] == pytest.approx(0.012, abs=0.001)
    assert ran(folder, "heal", "mine.yaml", "--undo", "--json")["undone"] is True
    assert robot_file.read_text() == old
    assert ran(folder, "heal", "mine.yaml", "--undo", "--json")["undone"] is False
    robot_file.write_text(f"{old}# by hand\n")
    assert "changed" in ran(folder, "heal", "mine.yaml", "--undo", status=2)["error"]


def test_a_healthy_robot_and_a_healed_one_are_left_alone(folder: Path) -> None:
    """A correction that the file has is not made once more."""
    text = put_robot(folder, FAULT)
    text += yaml.safe_dump({"effects": [FAULT]})
    (folder / "mine.yaml").write_text(text)
    answer = ran(folder, *CALL)
    assert answer["outcome"] == "nothing_to_heal"
    assert answer["by_hand"] == []
    assert (folder / "mine.yaml").read_text() == text
    assert "nothing to undo" in ran(folder, "heal", "mine.yaml", "--undo", status=2)["error"]
