"""From a table to its diagnosis without a second try: what is shown is typed, and asks nothing."""

from __future__ import annotations

import gzip
import json
import re
import shlex
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from deltactl.recording.foreign.inspection import inspect
from deltactl.recording.foreign.mapping import load_mapping
from deltactl.recording.foreign.reading import read_mapped
from tests.inspection.logs_of_makers import T_S, asked, current, seen
from tests.inspection.test_printed_commands import printed, put
from tests.inspection.test_shown import in_a_window

Deltactl = Callable[..., subprocess.CompletedProcess[str]]


def axis(
    path: Path, heading: str = "time,goal,place,torque", above: str = "", between: str = ","
) -> Path:
    """An axis of which nothing says the unit; above: lines before its heading."""
    table = np.stack([T_S, 0.2 * asked(), 0.2 * seen(), current()], axis=1)
    head = f"{above}{heading.replace(',', between)}"
    np.savetxt(path, table, "%.6f", between, header=head, comments="")
    return path


@pytest.mark.study
@pytest.mark.parametrize(("unit", "motion"), [("mm", "linear"), ("m", "linear"), ("deg", "rotary")])
@pytest.mark.parametrize("heading", ["time,goal,place,torque", ""])
def test_a_unit_is_said_once_and_both_commands_are_right(
    deltactl: Deltactl, tmp_path: Path, unit: str, motion: str, heading: str
) -> None:
    """And as long as it is not said, neither command runs."""
    axis(tmp_path / "log.csv", heading)
    shown = deltactl("inspect", "log.csv")
    said = [line for line in shown.stdout.splitlines() if f"MOTION is {motion}, UNIT is" in line]
    assert unit in re.split(r"\W+", said[0])
    init, command = printed(shown, "describe the machine:"), printed(shown)
    assert "must be rotary or linear" in deltactl(*init, status=2).stderr
    made = deltactl(*put(init, unit, motion))
    assert f"motion: {motion}" in (tmp_path / "log-robot.yaml").read_text()
    assert "--recorded" not in made.stdout
    assert "--zero" not in made.stdout
    assert "unit: 'UNIT' must be" in deltactl(*command, status=2).stderr
    done = deltactl(*put(command, unit, motion), "--json", "-")
    named = {"t": "time", "command": "goal", "position": "place"}
    if not heading:
        named = {"t": "column_1", "command": "column_2", "position": "column_3"}
    units = {"t": "s", "command": unit, "position": unit}
    sets = [w for name, one in named.items() for w in ("--set", f"{name}={one}[{units[name]}]")]
    long = deltactl("diagnose", "log.csv", "--robot", "log-robot.yaml", "--json", "-", *sets)
    assert json.loads(done.stdout)["findings"] == json.loads(long.stdout)["findings"]


def test_a_unit_of_the_other_motion_is_refused(deltactl: Deltactl, tmp_path: Path) -> None:
    axis(tmp_path / "log.csv")
    shown = deltactl("inspect", "log.csv")
    deltactl(*put(printed(shown, "describe the machine:"), "mm", "linear"))
    assert "this axis slides" in deltactl(*put(printed(shown), "deg", ""), status=2).stderr


def test_the_printed_init_command_asks_nothing(deltactl: Deltactl, tmp_path: Path) -> None:
    """Else it would take the next line of what was pasted for an answer."""
    axis(tmp_path / "log.csv", "time,goal_deg,place_deg,torque")
    words = printed(deltactl("inspect", "log.csv"), "describe the machine:")
    shown = in_a_window(tmp_path, 80, *words)
    assert "assumed:         --hanging-nm unknown" in shown
    assert "?" not in shown


@pytest.mark.study
def test_columns_without_a_heading_are_called_as_they_are_shown(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    axis(tmp_path / "named.csv")
    axis(tmp_path / "bare.txt", "", between="\t")
    deltactl("init", "axis", "axis.yaml", "--motion", "rotary")
    shown = deltactl("inspect", "bare.txt").stdout
    assert "heading=" not in shown
    names = {"t": "time", "command": "goal", "position": "place"}
    answers = []
    for file, called in (
        ("named.csv", names),
        ("bare.txt", dict(zip(names, (1, 2, 3), strict=True))),
    ):
        for column in called.values():
            assert isinstance(column, str) or re.search(rf"(?m)^column_{column} ", shown)
        sets = [f"{k}={v if isinstance(v, str) else f'column_{v}'}" for k, v in called.items()]
        words = [word for one in sets for word in ("--set", one)]
        done = deltactl("diagnose", file, "--robot", "axis.yaml", "--json", "-", *words)
        answers.append(json.loads(done.stdout)["findings"])
    assert answers[0] == answers[1]


@pytest.mark.parametrize("above", ["", "Fs,50\n", "Fs,50.00\nLogging time,3600\n\n"])
def test_lines_above_a_heading_need_no_saying(tmp_path: Path, above: str) -> None:
    plain = axis(tmp_path / "plain.csv")
    path = axis(tmp_path / "log.csv", above=above)
    mapping = load_mapping(None, ["t=time", "command=goal", "position=place"])
    for name in ("command", "position"):
        wanted = read_mapped(plain, mapping).column(name)
        np.testing.assert_array_equal(read_mapped(path, mapping).column(name), wanted)


def test_a_row_of_words_below_the_heading_does_not_take_its_place(tmp_path: Path) -> None:
    path = axis(tmp_path / "log.csv")
    first, *rows = path.read_text().splitlines()
    path.write_text("\n".join([first, "nan,nan,nan,nan", *rows]) + "\n")
    mapping = load_mapping(None, ["rate_hz=50", "command=goal", "position=place"])
    assert len(read_mapped(path, mapping).t_s) == len(rows) + 1


def test_a_rate_above_a_lone_column_is_used(deltactl: Deltactl, tmp_path: Path) -> None:
    rows = "\n".join(f"{80 + n % 5}.0" for n in range(400))
    (tmp_path / "still.csv").write_text(f"Fs,50.00\nLogging time,8\nd\n{rows}\n")
    first = " ".join(deltactl("inspect", "still.csv").stdout.split())
    assert "50 a second, as 'Fs,50.00' says" in first
    assert "rate_hz" not in first
    named = re.search(r"(--set range=d --set distance=)\S+", first)
    assert named is not None
    second = deltactl("inspect", "still.csv", *shlex.split(f"{named[1]}0.08"))
    assert deltactl(*printed(second, "describe the machine:")).returncode == 0
    command = printed(second)
    assert "rate_hz=50" in command
    assert deltactl(*command).returncode == 0


def test_recordings_that_are_read_alike_are_diagnosed_by_one_command(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    for name in ("a.csv", "b.csv"):
        axis(tmp_path / name, "time_ms,goal_deg,place_deg,torque")
    command = printed(deltactl("inspect", "a.csv", "b.csv"), "diagnose them:")
    assert command[:3] == ["diagnose", "a.csv", "b.csv"]
    axis(tmp_path / "c.csv", "time,goal_deg,place_deg,torque")
    apart = deltactl("inspect", "a.csv", "c.csv").stdout
    assert apart.count("diagnose it:") == 2


def test_a_packed_table_gives_its_own_name_to_a_second_machine(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    plain = axis(tmp_path / "slow.run.csv")
    (tmp_path / "slow.run.csv.gz").write_bytes(gzip.compress(plain.read_bytes()))
    made = printed(deltactl("inspect", "slow.run.csv.gz"), "describe the machine:")
    assert made[2] == "slow.run-robot.yaml"


def test_tables_of_one_folder_have_robot_files_of_their_own(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    for name in ("pan.csv", "tilt.csv"):
        axis(tmp_path / name)
        shown = deltactl("inspect", name)
        file = f"{name.removesuffix('.csv')}-robot.yaml"
        assert printed(shown, "describe the machine:")[2] == file
        command = printed(shown)
        assert command[command.index("--robot") + 1] == file


def test_angles_of_a_delta_ask_for_no_steps(deltactl: Deltactl, tmp_path: Path) -> None:
    names = [f"{what}_{n}" for what in ("command", "theta") for n in (1, 2, 3)]
    parts = [asked(n) for n in range(3)] + [seen(n) for n in range(3)]
    table = np.stack([T_S, *parts], axis=1)
    heading = ",".join(["t", *names])
    np.savetxt(tmp_path / "log.csv", table, "%.6f", ",", header=heading, comments="")
    command = printed(deltactl("inspect", "log.csv"), "describe the machine:")
    sizes = "--base-radius-mm 120 --platform-radius-mm 40 --upper-arm-mm 150 --forearm-mm 320"
    made = deltactl(*command, *sizes.split())
    assert "assumed" not in made.stdout


def test_what_moves_says_that_an_effort_was_recorded(deltactl: Deltactl, tmp_path: Path) -> None:
    given = ["--motion", "linear", "--inertia", "95", "--effort-gain", "35"]
    made = deltactl("init", "axis", "axis.yaml", *given)
    assert "--recorded" not in made.stdout
    assert inspect(axis(tmp_path / "log.csv")).kind == "servo_axis"
