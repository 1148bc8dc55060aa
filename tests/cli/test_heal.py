"""`deltactl heal`: a robot with a hidden fault draws better, a healthy one is kept as it is.

Whenever the program is killed, the robot file that was in force is in force.
"""

from __future__ import annotations

import json
import math
import os
import signal
import time
from pathlib import Path
from typing import Any

import pytest
import yaml

from deltactl.firmware_py.job_file import load_job
from deltactl.firmware_py.job_targets import kinematics_of
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.planner.plan import make_plan
from deltactl.firmware_py.robot_file import load_robot
from tests.rigs.started import started

ROBOT = (CONFIG_FOLDER / "zhao-2023.yaml").read_text()
FAULT = {"effect": "home_offset", "component": "motor2", "parameters": {"angle": 0.012}}
SENSOR = {"effect": "sensor_offset", "component": "range_y", "parameters": {"offset": 0.01}}
HEART = {
    "name": "small-heart",
    "robot": "mine.yaml",
    "path": {"shape": "heart", "centre_m": [0.0, 0.0, -0.45], "width_m": 0.08},
    "timing": {"mode": "together", "t_pwm_s": 0.002},
    "inverse_kinematics": {"kind": "geometry"},
}
CALL = ("heal", "mine.yaml", "--job", "small.yaml", "--simulate", "--minutes", "0.3", "--json")
WAIT_S = 240.0


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "small.yaml").write_text(yaml.safe_dump(HEART))
    return tmp_path


def put_robot(folder: Path, *faults: dict[str, Any]) -> str:
    text = ROBOT + ("\n" + yaml.safe_dump({"as_built": {"effects": list(faults)}}))
    (folder / "mine.yaml").write_text(text)
    return text


def killed_after(folder: Path, kinds: list[str], *words: str) -> None:
    """Begin, and kill the program as soon as recordings of these kinds are finished."""
    process, state = started(*words, cwd=folder), folder / "heal-mine" / "healing.json"
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


@pytest.mark.parametrize(
    "kills",
    [[["survey"]], pytest.param([[], ["survey"], ["survey", "before"]], marks=pytest.mark.study)],
)
def test_a_killed_healing_leaves_the_file_and_goes_on_and_is_undone(
    deltactl, folder: Path, kills: list[list[str]]
) -> None:
    old = put_robot(folder, FAULT)
    robot_file = folder / "mine.yaml"
    go_on = (*CALL, "--continue")
    for number, kinds in enumerate(kills):
        killed_after(folder, kinds, *(go_on if number else CALL))
        assert robot_file.read_text() == old
    answer = json.loads(deltactl(*go_on).stdout)
    assert answer["outcome"] == "healed"
    assert answer["before_ci95_m"][0] > 2.0 * answer["after_rms_m"]
    assert answer["gain_ci95_m2"][0] > 0.0
    (worth,) = answer["worth"]
    assert worth["ci95_m"][0] <= worth["alone_m"] < 0.2 * worth["now_m"]
    low_m, high_m = answer["before_ci95_m"]
    assert 0.9 * low_m < worth["now_m"] < 1.1 * high_m
    kinds = [Path(name).name.split("-")[0] for name in answer["recordings"]]
    assert kinds == ["survey", "before", "after"]
    (effect,) = yaml.safe_load(robot_file.read_text())["effects"]
    assert effect["effect"] == FAULT["effect"]
    assert effect["parameters"]["angle"] == pytest.approx(0.012, abs=0.001)
    undone = ("heal", "mine.yaml", "--undo", "--json")
    assert json.loads(deltactl(*undone).stdout)["undone"] is True
    assert robot_file.read_text() == old
    assert json.loads(deltactl(*undone).stdout)["undone"] is False
    robot_file.write_text(f"{old}# by hand\n")
    assert "changed" in deltactl(*undone, status=2).stderr


@pytest.mark.study
def test_a_robot_with_nothing_missing_in_its_file_is_not_changed(deltactl, folder: Path) -> None:
    """A correction that the file has is not made once more."""
    text = put_robot(folder, FAULT)
    text += yaml.safe_dump({"effects": [FAULT]})
    (folder / "mine.yaml").write_text(text)
    answer = json.loads(deltactl(*CALL).stdout)
    assert answer["outcome"] == "nothing_to_heal"
    assert answer["by_hand"] == []
    assert (folder / "mine.yaml").read_text() == text
    assert "nothing to undo" in deltactl("heal", "mine.yaml", "--undo", status=2).stderr


@pytest.mark.study
def test_a_healing_that_misses_its_goal_says_so(deltactl, folder: Path) -> None:
    """The correction helps and is kept, and is not called healed; it can be undone."""
    old = put_robot(folder, FAULT)
    call = tuple(word for word in CALL if word != "--json")
    shown = deltactl(*call, "--goal", "0.01", status=1).stdout
    assert shown.startswith("Better, but not healed")
    assert "goal 0.01 mm" in shown
    assert (folder / "mine.yaml").read_text() != old
    deltactl("heal", "mine.yaml", "--undo")
    assert (folder / "mine.yaml").read_text() == old


@pytest.mark.study
def test_a_correction_that_the_limits_forbid_is_refused(deltactl, folder: Path) -> None:
    """The corrected arms would have to go beyond the limits of the file in force."""
    put_robot(folder)
    robot_file, job = folder / "mine.yaml", load_job(folder / "small.yaml")
    robot = load_robot(robot_file)
    highest_rad = make_plan(job, robot, kinematics_of(job, robot, folder)).first.lap.angles_rad.max(
        axis=0
    )
    highest = int(highest_rad.argmax())
    above = {"component": f"motor{highest + 1}", "parameters": {"angle": -0.012}}
    put_robot(folder, FAULT | above)
    narrow = f"arm_deg: [-20, {math.degrees(highest_rad[highest]) + 0.1:.3f}]"
    old = robot_file.read_text().replace("arm_deg: [-20, 110]", narrow, 1)
    robot_file.write_text(old)
    answer = json.loads(deltactl(*CALL, status=1).stdout)
    assert answer["outcome"] == "refused"
    assert "limit" in answer["why"]
    assert robot_file.read_text() == old


@pytest.mark.study
def test_what_needs_a_hand_is_listed_until_it_is_done(deltactl, folder: Path) -> None:
    """No other command makes a sensor read right: somebody mends it, and healing goes on."""
    put_robot(folder, SENSOR)
    longer = (*CALL, "--minutes", "1")
    answer = json.loads(deltactl(*longer).stdout)
    assert answer["outcome"] == "nothing_to_heal"
    assert [one["component"] for one in answer["by_hand"]] == [SENSOR["component"]]
    put_robot(folder)
    after = json.loads(deltactl(*longer, "--continue").stdout)
    assert after["by_hand"] == []
    assert after["done_by_hand"] == [answer["by_hand"][0]["says"]]


def test_what_cannot_be_healed_is_said_before_anything_moves(deltactl, folder: Path) -> None:
    put_robot(folder)
    far = HEART | {"path": HEART["path"] | {"width_m": 3.0}}
    (folder / "far.yaml").write_text(yaml.safe_dump(far))
    deltactl("heal", "mine.yaml", "--job", "far.yaml", "--simulate", status=2)
    other = ROBOT.replace("gear_ratio: 10 ", "gear_ratio: 12 ")
    (folder / "other.yaml").write_text(other)
    (folder / "other-job.yaml").write_text(yaml.safe_dump(HEART | {"robot": "other.yaml"}))
    theirs = deltactl("heal", "mine.yaml", "--job", "other-job.yaml", "--simulate", status=2)
    assert "other.yaml, which describes another machine" in theirs.stderr
    assert not (folder / "heal-mine").exists()
    assert "--continue" in deltactl(*CALL, "--out", "none", "--continue", status=2).stderr
    assert "to undo" in deltactl("heal", "mine.yaml", "--undo", status=2).stderr
    assert "is an example" in deltactl("heal", "zhao-2023.yaml", "--simulate", status=2).stderr
