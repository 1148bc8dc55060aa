"""Two axes side by side: the first is looked at, the others are named."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from mcap.writer import Writer

from deltactl.recording.foreign.inspection import inspect

T_S = 0.02 * np.arange(300)


def motions() -> dict[str, np.ndarray]:  # type: ignore[type-arg]
    asked = {f"q{n}_ref": 0.5 * np.sin((1.0 + 0.2 * n) * T_S) for n in (1, 2)}
    seen = {f"q{n}": np.interp(T_S - 0.06, T_S, asked[f"q{n}_ref"]) for n in (1, 2)}
    return seen | asked


def write_csv(path: Path) -> None:
    columns = {"t": T_S, **motions()}
    table = np.stack(list(columns.values()), axis=1)
    np.savetxt(path, table, "%.5f", ",", header=",".join(columns), comments="")


def write_mcap(path: Path) -> None:
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        schema = writer.register_schema("axes", "jsonschema", b"{}")
        channel = writer.register_channel("/axes", "json", schema)
        for row, t_s in enumerate(T_S):
            data = {name: float(values[row]) for name, values in motions().items()}
            writer.add_message(channel, round(t_s * 1e9), json.dumps(data).encode(), 0)
        writer.finish()


@pytest.mark.parametrize(("write", "stem"), [(write_csv, ""), (write_mcap, "/axes.")])
def test_two_axes_are_no_delta(tmp_path: Path, write, stem: str) -> None:
    path = tmp_path / ("two.mcap" if write is write_mcap else "two.csv")
    write(path)
    found = inspect(path)
    assert found.kind == "servo_axis"
    taken = {guess.name: column for column, guess in found.guesses.items()}
    assert (taken["command"], taken["position"]) == (f"{stem}q1_ref", f"{stem}q1")
    (others,) = [one for one in found.warnings if "more joints than one" in one]
    assert f"{stem}q2, {stem}q2_ref" in others


@pytest.mark.parametrize("fault", ["play", "ratio", "offset", "none"])
def test_the_joint_that_departs_most_from_its_command_is_shown(tmp_path: Path, fault: str) -> None:
    """All of them follow late, the faster ones farther behind."""
    rng = np.random.default_rng(5)
    columns = {"t": T_S}
    for joint in range(1, 7):
        asked = 40.0 * np.sin((0.3 + 0.1 * joint) * T_S) + 15.0 * np.sin(1.1 * T_S + joint)
        seen = np.interp(T_S - 0.04, T_S, asked) + 0.02 * rng.standard_normal(len(T_S))
        if joint == 4:
            wrong = {
                "play": 0.6 * np.sign(np.gradient(asked)),
                "ratio": 0.02 * asked,
                "offset": 0.5,
                "none": 0.0,
            }
            seen = seen + wrong[fault]
        columns |= {f"joint{joint}_goal_deg": asked, f"joint{joint}_actual_deg": seen}
    table = np.stack(list(columns.values()), axis=1)
    path = tmp_path / "arm.csv"
    np.savetxt(path, table, "%.5f", ",", header=",".join(columns), comments="")
    taken = {guess.name: column for column, guess in inspect(path).guesses.items()}
    shown = 1 if fault == "none" else 4
    assert taken["position"] == f"joint{shown}_actual_deg"
    assert taken["command"] == f"joint{shown}_goal_deg"


@pytest.mark.parametrize(
    ("asked", "seen"),
    [
        (["J1_CmdPos_deg", "J2_CmdPos_deg", "J3_CmdPos_mm", "J4_CmdPos_deg"], "J{}_FbPos_{}"),
        (["DesRoll", "DesPitch", "DesYaw"], "{}"),
    ],
)
def test_joints_of_which_one_slides_and_joints_with_names_are_no_delta(
    tmp_path: Path, asked: list[str], seen: str
) -> None:
    """A SCARA, and a gimbal: the second joint of each has play."""
    columns = {"t": T_S}
    for n, name in enumerate(asked, 1):
        parts = name.partition("Des")[2:] if "Des" in name else (n, name.rpartition("_")[2])
        way = 30.0 * np.sin((0.4 + 0.1 * n) * T_S)
        play = 0.3 * np.sign(np.gradient(way)) if n == 2 else 0.0
        columns |= {name: way, seen.format(*parts): 0.998 * way + play}
    path = tmp_path / "arm.csv"
    table = np.stack(list(columns.values()), axis=1)
    np.savetxt(path, table, "%.5f", ",", header=",".join(columns), comments="")
    found = inspect(path)
    taken = {guess.name: column for column, guess in found.guesses.items()}
    assert found.kind == "servo_axis"
    assert taken["command"] == asked[1]


@pytest.mark.parametrize("loose", ["port", "starboard"])
def test_of_axes_with_several_quantities_the_one_that_departs_is_shown(
    tmp_path: Path, loose: str
) -> None:
    """Commands of speed, and what came of them, are beside those of place."""
    rng = np.random.default_rng(4)
    t_s = 0.1 * np.arange(2000)
    columns = {"time": t_s}
    for side, rate in (("port", 0.11), ("starboard", 0.13)):
        asked = 70.0 * np.sin(rate * t_s) + 8.0 * np.sin(0.7 * t_s)
        play = 0.8 * np.sign(np.gradient(asked)) * (side == loose)
        columns[f"{side}_rpm_cmd"] = 600.0 + 200.0 * np.sin(0.05 * t_s)
        columns[f"{side}_rpm_actual"] = columns[f"{side}_rpm_cmd"] + rng.normal(0.0, 5.0, len(t_s))
        columns[f"{side}_azimuth_cmd_deg"] = asked
        seen = np.interp(t_s - 0.1, t_s, asked) - play + rng.normal(0.0, 0.05, len(t_s))
        columns[f"{side}_azimuth_actual_deg"] = seen
    path = tmp_path / "boat.csv"
    table = np.stack(list(columns.values()), axis=1)
    np.savetxt(path, table, "%.3f", ",", header=",".join(columns), comments="")
    taken = {guess.name: column for column, guess in inspect(path).guesses.items()}
    assert taken["command"] == f"{loose}_azimuth_cmd_deg"
    assert taken["position"] == f"{loose}_azimuth_actual_deg"


def test_axes_of_a_mount_have_names_without_marks_between(tmp_path: Path) -> None:
    t_s = np.arange(1500.0)
    azimuth, altitude = 120.0 + 8.0 * np.sin(0.01 * t_s), 40.0 + 6.0 * np.sin(0.013 * t_s)
    worm = 0.006 * np.sin(np.pi * altitude)
    noise = 0.0005 * np.random.default_rng(7).standard_normal((2, len(t_s)))
    columns = [t_s, azimuth, azimuth + noise[0], altitude, altitude + worm + noise[1]]
    head = "time,TargetAz,ActualAz,TargetAlt,ActualAlt"
    path = tmp_path / "mount.csv"
    np.savetxt(path, np.stack(columns, axis=1), "%.5f", ",", header=head, comments="")
    seen = inspect(path)
    taken = {guess.name: column for column, guess in seen.guesses.items()}
    assert (taken["command"], taken["position"]) == ("TargetAlt", "ActualAlt")
    assert seen.motion == "rotary"
