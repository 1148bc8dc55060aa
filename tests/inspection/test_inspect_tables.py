"""Tables as people have them: what `inspect` takes them for, and that its command reads them."""

from __future__ import annotations

import json
import math
import shlex
import subprocess
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
import pytest
import yaml

from deltactl.foundation.errors import RecordingError
from deltactl.recording.foreign.found import Inspection
from deltactl.recording.foreign.inspection import inspect
from deltactl.recording.foreign.mapping import load_mapping
from deltactl.recording.foreign.reading import read_mapped
from deltactl.recording.tables.flat import FlatRecording
from tests.rigs.owners_words import owner_says

Deltactl = Callable[..., subprocess.CompletedProcess[str]]
ROWS = 900
T_S = 0.01 * np.arange(ROWS)
COMMAND = 0.8 * np.sin(2.0 * T_S) + 0.3 * np.sin(3.1 * T_S)
NOISE = np.random.default_rng(5).standard_normal(ROWS)
POSITION = np.interp(T_S - 0.05, T_S, COMMAND) + 0.002 * NOISE
SPEED = np.gradient(POSITION, T_S)
EFFORT = 2.0 * np.gradient(np.gradient(COMMAND, T_S), T_S) + np.sign(SPEED) + 0.05 * NOISE


def text(rows: Iterable[Iterable[float]], separator: str = ",", decimal: str = ".") -> str:
    return "".join(
        separator.join(f"{value:.6f}".replace(".", decimal) for value in row) + "\n" for row in rows
    )


def taken(found: Inspection) -> dict[str, str]:
    return {guess.name: guess.source for guess in found.guesses.values()}


def read_as_told(found: Inspection) -> FlatRecording:
    """What the command that was printed reads."""
    options = owner_says(found)
    return read_mapped(found.path, load_mapping(None, options))


def columns(*parts: np.ndarray) -> Iterable[Iterable[float]]:
    return np.stack(parts, axis=1).tolist()


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "cp1252", "utf-16"])
@pytest.mark.parametrize(
    ("separator", "decimal"), [(";", ","), ("\t", ","), (";", "."), ("\t", "."), ("|", ".")]
)
def test_a_spreadsheets_export(tmp_path: Path, encoding: str, separator: str, decimal: str) -> None:
    head = separator.join(["Zeit [ms]", "Istwert [°]", "Sollwert [°]"])
    body = text(columns(1e3 * T_S, np.degrees(POSITION), np.degrees(COMMAND)), separator, decimal)
    path = tmp_path / "export.csv"
    path.write_bytes(f"Prüfstand 7\n\n{head}\n{body}".replace("\n", "\r\n").encode(encoding))
    found = inspect(path)
    assert (found.kind, found.motion) == ("servo_axis", "rotary")
    read = read_as_told(found)
    np.testing.assert_allclose(read.t_s, T_S, atol=1e-6)
    np.testing.assert_allclose(read.column("position"), POSITION, atol=1e-6)
    np.testing.assert_allclose(read.column("command"), COMMAND, atol=1e-6)


def test_a_set_position_is_the_command_and_a_laser_the_position(tmp_path: Path) -> None:
    path = tmp_path / "stage.csv"
    path.write_text("Time;SetPos_mm;Laser_mm\n" + text(columns(T_S, COMMAND, POSITION), ";", ","))
    found = inspect(path)
    assert (found.kind, found.motion) == ("servo_axis", "linear")
    assert taken(found) == {"t": "Time", "command": "SetPos_mm", "position": "Laser_mm"}


def test_a_line_of_units_under_the_heading_and_a_comment_mark(tmp_path: Path) -> None:
    path = tmp_path / "log.txt"
    path.write_text("# time\ttarget\tencoder\n# s\tmm\tmm\n" + text(
        columns(T_S, 100 * COMMAND, 100 * POSITION), "\t"
    ))  # fmt: skip
    found = inspect(path)
    assert (found.kind, found.motion) == ("servo_axis", "linear")
    read = read_as_told(found)
    np.testing.assert_allclose(read.column("position"), 0.1 * POSITION, atol=1e-6)


@pytest.mark.parametrize("order", [(0, 1, 2, 3), (3, 2, 0, 1), (1, 3, 2, 0)])
def test_without_any_names(tmp_path: Path, order: tuple[int, ...]) -> None:
    """Time, command, position and effort, in any order."""
    parts = [T_S, COMMAND, POSITION, EFFORT]
    path = tmp_path / "bare.csv"
    path.write_text(text(columns(*(parts[n] for n in order))))
    found = inspect(path)
    wanted = {name: f"column_{order.index(n) + 1}" for n, name in enumerate(
        ("t", "command", "position", "effort"))}  # fmt: skip
    assert taken(found) == wanted
    np.testing.assert_allclose(read_as_told(found).column("effort"), EFFORT, atol=1e-6)


def test_position_speed_and_effort_without_names(tmp_path: Path) -> None:
    path = tmp_path / "bare.csv"
    path.write_text(text(columns(T_S, COMMAND, np.gradient(COMMAND, T_S), EFFORT)))
    assert taken(inspect(path)) == {
        "t": "column_1", "position": "column_2", "velocity": "column_3", "effort": "column_4"
    }  # fmt: skip


def test_counts_and_an_angle_are_a_stepper_axis(tmp_path: Path) -> None:
    counts = np.round(COMMAND * 50_000)
    path = tmp_path / "bare.csv"
    path.write_text(text(columns(T_S, counts, POSITION)))
    found = inspect(path)
    assert found.kind == "stepper_axis"
    assert taken(found) == {"t": "column_1", "steps_1": "column_2", "theta_1": "column_3"}


def test_counts_and_a_reading_in_mm_are_a_slide_and_no_gear(tmp_path: Path) -> None:
    path = tmp_path / "slide.csv"
    path.write_text(
        "t,steps,pos_mm\n" + text(columns(T_S, np.round(COMMAND * 80e3), COMMAND * 1e3))
    )
    found = inspect(path)
    assert (found.kind, found.motion) == ("servo_axis", "linear")
    assert taken(found) == {"t": "t", "command": "steps", "position": "pos_mm"}
    assert "command=steps[mm]*0.0125" in owner_says(found)
    assert "command=steps[mm]*MM_PER_STEP" in found.options
    assert "in this recording 0.0125" in found.factors["command"].says
    assert "steps: taken for the steps of a slide" in found.warnings[-1]
    np.testing.assert_allclose(read_as_told(found).columns["command"], COMMAND, atol=1e-4)


def test_a_distance_that_a_laser_read_is_no_effort(tmp_path: Path) -> None:
    path = tmp_path / "laser.csv"
    path.write_text("t,x,Laser_mm\n" + text(columns(T_S, COMMAND * 1e3, POSITION * 1e3)))
    found = inspect(path)
    assert (found.kind, found.motion) == ("servo_axis", "linear")
    assert taken(found) == {"t": "t", "command": "x", "position": "Laser_mm"}
    assert any("x: taken for the command" in warning for warning in found.warnings)


def test_three_joints_counted_from_nought(tmp_path: Path) -> None:
    path = tmp_path / "delta.csv"
    head = "time," + ",".join(f"cmd_{n},joint_pos_{n}" for n in range(3))
    parts = [part * (1 + n) for n in range(3) for part in (COMMAND, POSITION)]
    path.write_text(f"{head}\n" + text(columns(T_S, *parts)))
    found = inspect(path)
    assert found.kind == "delta"
    assert taken(found)["command_3"] == "cmd_2"
    assert taken(found)["theta_1"] == "joint_pos_0"


def test_true_and_reported_distances(tmp_path: Path) -> None:
    true = np.repeat([0.3, 0.5, 0.9, 1.4, 0.7, 0.2], ROWS // 6)
    path = tmp_path / "range.csv"
    path.write_text(text(columns(T_S, true, 1.02 * true + 0.004 * NOISE)))
    found = inspect(path)
    assert found.kind == "range_sensor"
    assert taken(found) == {"t": "column_1", "distance": "column_2", "range": "column_3"}


def test_degrees_against_radians_are_seen(tmp_path: Path) -> None:
    path = tmp_path / "mixed.csv"
    path.write_text("t,command,position\n" + text(columns(T_S, np.degrees(COMMAND), POSITION)))
    found = inspect(path)
    assert any("deg against rad" in warning for warning in found.warnings)
    np.testing.assert_allclose(read_as_told(found).column("command"), COMMAND, atol=1e-6)


@pytest.mark.parametrize(
    ("name", "factor", "warned"),
    [
        ("angle_rad", 57.0, "degrees"), ("position_m", 40.0, "millimetres"),
        ("angle_deg", 0.1, "radians"), ("encoder", 4096.0, "encoder counts"),
    ],
)  # fmt: skip
def test_values_that_look_like_another_unit(
    tmp_path: Path, name: str, factor: float, warned: str
) -> None:
    values = np.round(factor * POSITION) if name == "encoder" else factor * POSITION
    path = tmp_path / "odd.csv"
    path.write_text(f"t,{name},effort\n" + text(columns(T_S, values, EFFORT)))
    assert any(warned in warning for warning in inspect(path).warnings)


def test_whole_numbers_of_a_servo_are_read_as_counts_unless_somebody_knows(tmp_path: Path) -> None:
    path = tmp_path / "servo.csv"
    counts = [np.round(2048 + one * 4096 / math.tau) for one in (COMMAND, POSITION)]
    path.write_text("t,goal_position,present_position\n" + text(columns(T_S, *counts)))
    found = inspect(path)
    assert found.motion == "rotary"
    (warning,) = [warning for warning in found.warnings if "4096 a turn" in warning]
    assert warning.startswith("goal_position, present_position: ")
    read_rad = read_as_told(found).column("command")
    np.testing.assert_allclose(read_rad - np.pi, COMMAND, atol=3e-3)
    said = load_mapping(None, ["command=goal_position*0.01", "position=present_position*0.01"])
    told = inspect(path, said)
    assert not any("4096" in warning for warning in told.warnings)
    assert "command=goal_position*0.01" in told.options


@pytest.mark.parametrize(("scale", "unit"), [(1.0, "s"), (1e3, "ms"), (1e6, "us"), (1e9, "ns")])
def test_time_in_ticks(tmp_path: Path, scale: float, unit: str) -> None:
    path = tmp_path / "ticks.csv"
    time = T_S if unit == "s" else np.round(T_S * scale + 17 * scale)
    path.write_text("timestamp,command,position\n" + text(columns(time, COMMAND, POSITION)))
    found = inspect(path)
    assert found.guesses["timestamp"].unit == unit
    assert np.diff(read_as_told(found).t_s)[0] == pytest.approx(0.01, rel=1e-3)


def test_dates_become_seconds(tmp_path: Path) -> None:
    rows = "".join(
        f"2026-03-01 12:{int(s // 60):02d}:{math.fmod(s, 60):06.3f},{c:.6f},{p:.6f}\n"
        for s, c, p in zip(T_S, COMMAND, POSITION, strict=True)
    )
    path = tmp_path / "dates.csv"
    path.write_text("time,command,position\n" + rows)
    np.testing.assert_allclose(read_as_told(inspect(path)).t_s, T_S, atol=1e-6)


def test_the_command_line_shows_it_and_saves_the_mapping(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    (tmp_path / "log.csv").write_text(
        "Zeit;Soll [°];Ist [°]\n"
        + text(columns(T_S, np.degrees(COMMAND), np.degrees(POSITION)), ";", ",")
    )
    (tmp_path / "axis.yaml").write_text("kind: servo_axis\nname: mine\nmotion: rotary\n")
    shown = deltactl("inspect", "log.csv", "--save-columns", "log.yaml").stdout
    assert "decimal comma" in shown
    assert "deltactl init axis log-robot.yaml --motion rotary" in shown
    assert "deltactl diagnose log.csv --robot log-robot.yaml --columns log.yaml" in shown
    done = deltactl(
        "diagnose", "log.csv", "--robot", "axis.yaml", "--columns", "log.yaml", "--json", "-"
    )
    assert json.loads(done.stdout)["findings"][0]["effect"] == "following_lag"
    again = deltactl("inspect", "log.csv", "--save-columns", "log.yaml", status=2)
    assert "exists already" in again.stderr


def test_a_table_without_our_names_points_here(deltactl: Deltactl, tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("a;b\n1;2\n2;3\n")
    refused = deltactl("diagnose", "log.csv", "--robot", "zhao-2023.yaml", status=2)
    assert "deltactl inspect log.csv" in refused.stderr


@pytest.mark.parametrize("content", ["", "only words\nand more words\n", "\x00\x01\x02"])
def test_no_table_is_one_line(deltactl: Deltactl, tmp_path: Path, content: str) -> None:
    (tmp_path / "none.csv").write_text(content)
    refused = deltactl("inspect", "none.csv", status=2)
    assert refused.stderr.startswith("deltactl: none.csv")
    assert len(refused.stderr.splitlines()) == 1


@pytest.mark.parametrize(("shift", "zero"), [(0.02, "absolute"), (7.0, "arbitrary")])
def test_readings_that_stand_far_from_the_commands_have_a_zero_of_their_own(
    tmp_path: Path, shift: float, zero: str
) -> None:
    path = tmp_path / "shifted.csv"
    path.write_text("t,command,position\n" + text(columns(T_S, COMMAND, POSITION + shift)))
    assert inspect(path).zero == zero


def test_what_is_said_of_a_column_is_taken_and_printed_back(
    tmp_path: Path, deltactl: Deltactl
) -> None:
    """The inspection says what to say, takes it, and its command reads the table so."""
    path = tmp_path / "log.csv"
    rows = zip(T_S, POSITION, EFFORT, strict=True)
    path.write_text("stamp,q,amperes_seen\n" + text(rows))
    unknown = inspect(path)
    assert unknown.kind is None
    assert "--set effort=amperes_seen" in unknown.kind_why
    known = inspect(path, load_mapping(None, ["effort=amperes_seen*2.5"]))
    assert known.kind == "servo_axis"
    assert known.guesses["amperes_seen"].why == "as you say"
    np.testing.assert_allclose(read_as_told(known).columns["effort"], 2.5 * EFFORT, atol=1e-5)
    with pytest.raises(RecordingError, match=r"column 'amps' \(for effort\) is missing.*q, amp"):
        inspect(path, load_mapping(None, ["effort=amps"]))
    other = inspect(path, load_mapping(None, ["position=amperes_seen[mm]", "effort=q"]))
    assert taken(other) == {"t": "stamp", "position": "amperes_seen", "effort": "q"}
    assert other.motion == "linear"
    shown = deltactl("inspect", "log.csv", "--set", "effort=amperes_seen").stdout
    assert "deltactl init axis log-robot.yaml" in shown
    assert "--measure log.csv" in shown or "--recorded effort --inertia INERTIA" in shown
    (tmp_path / "log-robot.yaml").write_text("another machine's\n")
    again = deltactl("inspect", "log.csv", "--set", "effort=amperes_seen").stdout
    assert "deltactl init axis log-robot-2.yaml" in again


@pytest.mark.parametrize(
    ("heading", "asked", "seen", "unit"),
    [
        ("t,cmd_mm,dial_in", 20 * COMMAND, POSITION / 1.27, "inch"),
        ("t,steps,dial_in", np.round(2000 * COMMAND), POSITION / 1.27, "inch"),
        ("t,cmd_mm,pos_in", 20 * COMMAND, 20 * POSITION, "mm"),  # of in and out
        ("t,target_q_3,actual_q_3", COMMAND, POSITION, "rad"),
    ],
)
def test_units_that_headings_and_values_say_together(
    tmp_path: Path, heading: str, asked: np.ndarray, seen: np.ndarray, unit: str
) -> None:
    """A dial's inches were asked for, beside steps taken for rad; RTDE is always in rad."""
    path = tmp_path / "log.csv"
    path.write_text(f"{heading}\n" + text(columns(T_S, asked, seen)))
    found = inspect(path)
    assert found.guesses[heading.split(",")[2]].unit == unit
    assert found.asked is None


def test_the_robot_file_named_after_a_table_is_used_if_it_is_of_its_machine(
    tmp_path: Path, deltactl: Deltactl
) -> None:
    for name in ("log.csv", "other.csv"):
        rows = columns(T_S, 20 * COMMAND, 20 * POSITION)
        (tmp_path / name).write_text("t,target_mm,seen_mm\n" + text(rows))
    init = ("init", "axis", "log-robot.yaml", "--recorded", "command", "--yes", "--motion")
    deltactl(*init, "linear")
    for recordings in (["log.csv"], ["log.csv", "other.csv"]):
        shown = deltactl("inspect", *recordings).stdout
        assert "described already:     log-robot.yaml" in shown
        assert f"deltactl diagnose {' '.join(recordings)} --robot log-robot.yaml" in shown
        assert "describe the machine" not in shown
    deltactl(*init, "rotary", "--force")
    shown = deltactl("inspect", "log.csv").stdout
    assert "not of log-robot.yaml" in shown
    assert "--force" in shown
    assert "init axis log-robot-2.yaml --motion linear" in shown


def test_motors_with_letters_are_three_and_have_one_unit(tmp_path: Path) -> None:
    """Of soll_A to soll_C, two once were amperes, and only the widest was in degrees."""
    wide = [5.0, 7.0, 15.0]
    asked = [by * COMMAND for by in wide]
    seen = [by * POSITION for by in wide]
    path = tmp_path / "delta.csv"
    head = "zeit,soll_A,soll_B,soll_C,ist_A,ist_B,ist_C\n"
    path.write_text(head + text(columns(T_S, *asked, *seen)))
    found = inspect(path)
    assert found.kind == "delta"
    assert taken(found)["command_2"] == "soll_B"
    assert {guess.unit for guess in found.guesses.values() if guess.role != "t"} == {"deg"}
    assert "theta_1=ist_A[deg]" in found.options


def test_a_table_of_true_and_measured_distances_is_a_range_sensors(tmp_path: Path) -> None:
    path = tmp_path / "room.csv"
    rows = [f"{n},{true:.1f},{true + 3:.1f},{n // 5}" for n, true in enumerate(range(80, 400, 4))]
    path.write_text("\n".join(["n,true_cm,measured_cm,spot", *rows]) + "\n")
    found = inspect(path)
    assert found.kind == "range_sensor"
    assert taken(found) == {"distance": "true_cm", "range": "measured_cm", "segment": "spot"}
    assert found.warnings == []
    np.testing.assert_allclose(np.diff(read_as_told(found).t_s), 1.0)


def test_a_drives_voltage_is_what_moves_the_axis(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    body = text(columns(1e3 * T_S, 1e3 * COMMAND, 1e3 * POSITION, EFFORT), ";", ",")
    path.write_text(f"Zeit [ms];Soll [mm];Ist [mm];Spannung [V]\n{body}")
    found = inspect(path)
    assert taken(found)["effort"] == "Spannung [V]"
    assert (found.kind, found.motion) == ("servo_axis", "linear")


@pytest.mark.parametrize("goes_with_it", [True, False])
def test_the_command_for_a_log_of_currents_runs_and_says_what_moves(
    deltactl: Deltactl, tmp_path: Path, goes_with_it: bool
) -> None:
    """A VESC log: amperes and an angle; the torque of one ampere is unknown."""
    t_s = 0.01 * np.arange(3000)
    angle = np.sin(2.0 * t_s) + 0.5 * np.sin(3.1 * t_s)
    speed = np.gradient(angle, t_s)
    noise = np.random.default_rng(4).standard_normal((2, len(t_s)))
    effort = 0.3 * np.gradient(speed, t_s) * goes_with_it + 0.5 * np.sign(speed) + 0.02 * noise[0]
    table = np.stack([1e3 * t_s, effort, np.degrees(angle + 1e-4 * noise[1])], axis=1)
    head = "ms_today,current_motor,tacho_deg"
    np.savetxt(tmp_path / "vesc.csv", table, "%.6f", ",", header=head, comments="")
    shown = deltactl("inspect", "vesc.csv").stdout
    (command,) = [line for line in shown.splitlines() if line.startswith("describe the machine")]
    words = shlex.split(command.partition("deltactl ")[2])
    assert ("INERTIA" in words) is not goes_with_it
    if goes_with_it:
        made = deltactl(*words)
        assert made.returncode == 0, made.stderr
        robot = yaml.safe_load((tmp_path / "vesc-robot.yaml").read_text())
        assert robot["inertia"] == pytest.approx(0.3, rel=0.1)
        other = deltactl(*words, "--effort-gain", "0.5", "--force")
        assert other.returncode == 0, other.stderr
        robot = yaml.safe_load((tmp_path / "vesc-robot.yaml").read_text())
        assert robot["inertia"] == pytest.approx(0.15, rel=0.1)
