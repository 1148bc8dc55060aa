"""What is said where columns are missing that the table has under other names, or of no use."""

from __future__ import annotations

import shlex
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from deltactl.recording.foreign.inspection import inspect
from deltactl.recording.foreign.mapping import load_mapping
from deltactl.recording.foreign.reading import read_mapped
from tests.inspection.logs_of_makers import PERIOD_S, T_S, asked, current, seen
from tests.rigs.owners_words import owner_says

Deltactl = Callable[..., subprocess.CompletedProcess[str]]
SIZES_MM = {"base-radius": "122", "platform-radius": "100", "upper-arm": "314", "forearm": "587"}
AXIS = "kind: servo_axis\nname: mine\nmotion: rotary\n"


def write(path: Path, head: str, *columns: np.ndarray) -> Path:
    rows = np.stack(columns, axis=1)
    np.savetxt(path, rows, "%.5f", ",", header=head, comments="", encoding="utf-8")
    return path


@pytest.mark.study
def test_a_delta_without_angles_is_told_which_columns_look_like_them(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    arms = [0.2 * part(n) for part in (asked, seen) for n in range(3)]
    head = "ms,ax1_cmd,ax2_cmd,ax3_cmd,ax1_act,ax2_act,ax3_act"
    write(tmp_path / "log.csv", head, 1e3 * T_S, *np.degrees(arms))
    sizes = [word for name, mm in SIZES_MM.items() for word in (f"--{name}-mm", mm)]
    deltactl("init", "delta", "delta.yaml", *sizes, "--gear-ratio", "1")
    options = ["--set", "t=ms"]
    for motor in (1, 2, 3):
        options += ["--set", f"command_{motor}=ax{motor}_cmd[deg]"]
    says = deltactl("diagnose", "log.csv", "--robot", "delta.yaml", *options, status=2).stderr
    assert "Here ax1_act, ax2_act, ax3_act look like theta_1, theta_2, theta_3: add" in says
    more = shlex.split(says.split(": add ")[1])
    assert more[:2] == ["--set", "theta_1=ax1_act[deg]"]
    deltactl("diagnose", "log.csv", "--robot", "delta.yaml", *options, *more)


@pytest.mark.study
def test_a_torque_beside_a_command_may_be_a_load(deltactl: Deltactl, tmp_path: Path) -> None:
    head = "ms,goal,present,torque_Nm"
    path = write(tmp_path / "log.csv", head, 1e3 * T_S, asked(), seen(), current())
    (warning,) = [one for one in inspect(path).warnings if "torque_Nm" in one]
    assert "put load in place of effort" in warning
    assert not [one for one in inspect(path).warnings if "the file gives no unit" in one]
    (tmp_path / "axis.yaml").write_text(AXIS)
    options = ["--set", "t=ms", "--set", "command=goal", "--set", "position=present"]
    effort = ["--set", "effort=torque_Nm"]
    done = deltactl("diagnose", "log.csv", "--robot", "axis.yaml", *options, *effort)
    (line,) = [one for one in done.stderr.splitlines() if "effort" in one]
    assert line.startswith("log.csv: effort is not used, as the robot file has no `inertia`")
    assert line.endswith("--set load=torque_Nm")
    load = ["--set", "load=torque_Nm"]
    done = deltactl("diagnose", "log.csv", "--robot", "axis.yaml", *options, *load)
    assert "not used" not in done.stderr


def test_a_current_pulls_from_nowhere_outside(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", "t,goal,present,current", T_S, asked(), seen(), current())
    assert not [one for one in inspect(path).warnings if "load" in one]


@pytest.mark.parametrize("name", ["axis-1", "q*", "speed+2", "joint[1]", "12"])
def test_names_that_look_like_factors_or_offsets_are_read_back(tmp_path: Path, name: str) -> None:
    path = write(tmp_path / "a.csv", f"t,goal,{name}", T_S, asked(), seen())
    found = inspect(path, load_mapping(None, [f'position="{name}"[deg]']))
    read = read_mapped(path, load_mapping(None, owner_says(found)))
    np.testing.assert_allclose(read.column("position"), np.radians(seen()), atol=1e-5)
    assert read.period_s() == pytest.approx(PERIOD_S)


def test_names_that_the_program_knows_are_where_it_says(deltactl: Deltactl, tmp_path: Path) -> None:
    write(tmp_path / "a.csv", "t,foo", T_S, asked())
    (tmp_path / "axis.yaml").write_text(AXIS)
    says = deltactl("diagnose", "a.csv", "--robot", "axis.yaml", status=2).stderr
    assert "contract" not in says
    assert "docs/reference/columns.md" in says
