"""The command that `inspect` prints runs as it is, with the robot file that was given too."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from deltactl.foundation.one_screen import LINES
from tests.inspection.logs_of_makers import T_S, asked, current, seen
from tests.inspection.test_shown import in_a_window

Deltactl = Callable[..., subprocess.CompletedProcess[str]]
UNSAID = "time,goal,place,speed,torque"


def write(path: Path, heading: str, size: float = 1.0) -> None:
    """An axis whose units nothing says; without a heading, columns without names."""
    way = size * seen()
    parts = [T_S, size * asked(), way, np.gradient(way, T_S), current()]
    np.savetxt(path, np.stack(parts, axis=1), "%.5f", ",", header=heading, comments="")


def printed(done: subprocess.CompletedProcess[str], label: str = "diagnose it:") -> list[str]:
    (line,) = [one for one in done.stdout.splitlines() if one.startswith(label)]
    return shlex.split(line.removeprefix(label))[1:]


def put(words: Sequence[str], unit: str, motion: str) -> list[str]:
    """A printed command with what it leaves to the owner of the table."""
    said = {"unit=UNIT": f"unit={unit}", "MOTION": motion}
    return [said.get(word, word) for word in words]


def refused(done: subprocess.CompletedProcess[str]) -> Sequence[str]:
    return [one for one in done.stderr.splitlines() if one.startswith("deltactl:")]


@pytest.mark.study
@pytest.mark.parametrize(("motion", "unit"), [("linear", "m"), ("rotary", "rad")])
@pytest.mark.parametrize("heading", [UNSAID, ""])
def test_units_are_those_of_the_motion_in_the_robot_file(
    deltactl: Deltactl, tmp_path: Path, motion: str, unit: str, heading: str
) -> None:
    write(tmp_path / "log.csv", heading)
    deltactl("init", "axis", "axis.yaml", "--motion", motion)
    shown = deltactl("inspect", "log.csv", "--robot", "axis.yaml")
    (choice,) = [line for line in shown.stdout.splitlines() if line.startswith("  UNIT, of ")]
    assert {"m", "mm"}.isdisjoint(re.findall(r"\w+", choice)) == (motion == "rotary")
    (why,) = refused(deltactl(*printed(shown), status=2))
    assert "unit: 'UNIT' must be" in why
    (why,) = refused(deltactl("diagnose", "log.csv", "--robot", "axis.yaml", status=2))
    assert "nothing says the unit of" in why
    command = put(printed(shown), unit, motion)
    said = printed(deltactl("inspect", "log.csv", "--robot", "axis.yaml", "--set", f"unit={unit}"))
    units = {word.split("=")[0]: word[word.index("[") :] for word in said if "[" in word}
    assert {units["position"], units["command"]} == {f"[{unit}]"}
    assert units.get("velocity", f"[{unit}/s]") == f"[{unit}/s]"
    done = deltactl(*command)
    assert done.returncode == 0
    assert "effort is not used" not in done.stderr
    answers = [json.loads(deltactl(*one, "--json", "-").stdout) for one in (command, said)]
    assert answers[0]["findings"] == answers[1]["findings"]


def test_an_effort_is_read_where_the_robot_file_has_an_inertia(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    write(tmp_path / "log.csv", UNSAID)
    sizes = ["--recorded", "both", "--inertia", "1", "--effort-gain", "1"]
    deltactl("init", "axis", "moved.yaml", "--motion", "rotary", *sizes)
    deltactl("init", "axis", "axis.yaml", "--motion", "rotary")
    with_mass = printed(deltactl("inspect", "log.csv", "--robot", "moved.yaml"))
    without = printed(deltactl("inspect", "log.csv", "--robot", "axis.yaml"))
    assert "effort=torque" in with_mass
    assert not [word for word in without if word.startswith("effort")]


@pytest.mark.study
def test_a_table_of_another_machine_gets_a_robot_file_of_its_own(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    write(tmp_path / "log.csv", "time,goal_deg,place_deg,speed,torque", 40.0)
    deltactl("init", "axis", "my-robot.yaml", "--motion", "linear")
    done = deltactl("inspect", "log.csv", "--robot", "my-robot.yaml")
    assert "this axis slides" in done.stdout
    assert deltactl(*printed(done, "describe the machine:")).returncode == 0
    assert deltactl(*printed(done)).returncode == 0
    (why,) = refused(deltactl("diagnose", "log.csv", "--robot", "my-robot.yaml", status=2))
    assert "this axis slides (motion: linear in the robot file)" in why


@pytest.mark.study
def test_a_column_is_left_out_by_an_empty_name(deltactl: Deltactl, tmp_path: Path) -> None:
    write(tmp_path / "log.csv", "t,command,position,velocity,effort")
    deltactl("init", "axis", "axis.yaml", "--motion", "rotary")
    read = ["diagnose", "log.csv", "--robot", "axis.yaml"]
    assert "effort is not used" in deltactl(*read).stderr
    assert "effort is not used" not in deltactl(*read, "--set", "effort=").stderr


def arm(path: Path) -> None:
    names = [f"{what}_{n}" for what in ("theta", "velocity", "effort") for n in range(1, 7)]
    columns = [np.sin((0.3 + 0.1 * n) * T_S + n) for n in range(len(names))]
    heading = ",".join(["t", *names])
    np.savetxt(path, np.stack([T_S, *columns], axis=1), "%.5f", ",", header=heading, comments="")


@pytest.mark.study
def test_a_chain_is_read_by_its_own_columns(deltactl: Deltactl, tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    from tests.diagnosis.test_chain_by_poses import urdf_text

    (tmp_path / "arm.urdf").write_text(urdf_text())
    arm(tmp_path / "arm.csv")
    made = deltactl("init", "chain", "arm.yaml", "--model", "arm.urdf")
    assert "assumed:         --effort-gain 1" in made.stdout
    command = printed(deltactl("inspect", "arm.csv", "--robot", "arm.yaml"))
    assert command == ["diagnose", "arm.csv", "--robot", "arm.yaml"]
    assert deltactl(*command).returncode == 0
    (why,) = refused(deltactl(*command, "--set", "position=theta_1[rad]", status=2))
    assert "leave out --set position" in why


@pytest.mark.study
def test_columns_that_are_used_are_shown_first_on_one_screen(tmp_path: Path) -> None:
    others = [
        f"flag_{name}" for name in ("on", "off", "ready", "fault", "warm", "cold", "open", "shut")
    ]
    parts = [T_S, *[np.full(len(T_S), 7.0)] * len(others), asked(), seen(), current()]
    heading = ",".join(["time", *others, "goal", "place", "torque_Nm"])
    table = np.stack(parts, axis=1)
    np.savetxt(tmp_path / "log.csv", table, "%.5f", ",", header=heading, comments="")
    shown = in_a_window(tmp_path, 80, "inspect", "log.csv").splitlines()
    assert len(shown) <= LINES
    start = next(n for n, line in enumerate(shown) if line.startswith("column "))
    first = [line.split()[0] for line in shown[start + 1 : start + 5]]
    assert first == ["time", "goal", "place", "torque_Nm"]


@pytest.mark.study
def test_names_in_a_message_are_whole(deltactl: Deltactl, tmp_path: Path) -> None:
    names = [f"{axis}_ActualMeasurement" for axis in "ABCDEFGHIJKLMNO"]
    parts = [np.sin(T_S + n) for n in range(len(names))]
    table = np.stack(parts, axis=1)
    np.savetxt(tmp_path / "log.csv", table, "%.5f", ",", header=",".join(names), comments="")
    deltactl("init", "axis", "axis.yaml", "--motion", "rotary")
    (why,) = refused(deltactl("diagnose", "log.csv", "--robot", "axis.yaml", status=2))
    listed = why[why.index("A_Actual") :].split(" and ")[0]
    assert set(listed.split(", ")) < set(names)
    assert f"and {len(names) - len(listed.split(', '))} more" in why


@pytest.mark.parametrize(
    ("heading", "words"),
    [
        ("t,knee_deg,knee_torque_Nm", ["--effort-gain", "1"]),
        ("t,knee_deg,knee_current_A", ["--effort-gain", "GAIN"]),
        ("t,slide_mm,drive_force_N", ["--effort-gain", "1"]),
        ("t,arm_deg,pull_force_N", ["--effort-gain", "GAIN"]),
    ],
)
def test_an_effort_in_the_unit_that_moves_the_axis_needs_no_gain(
    deltactl: Deltactl, tmp_path: Path, heading: str, words: list[str]
) -> None:
    friction = np.sign(np.gradient(seen()))
    cells = np.stack([T_S, 30.0 * seen(), friction], axis=1)
    np.savetxt(tmp_path / "log.csv", cells, "%.5f", ",", header=heading, comments="")
    shown = deltactl("inspect", "log.csv")
    init = printed(shown, "describe the machine:")
    at = init.index("--effort-gain")
    assert init[at : at + 2] == words
    assert ("GAIN: N" in shown.stdout) == ("GAIN" in words)
    assert (
        deltactl(*("1" if word in ("GAIN", "INERTIA") else word for word in init)).returncode == 0
    )
