"""Tables of several axes, of efforts beside commands, of too few rows, and of no machine at all."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import numpy as np
import pytest

from deltactl.recording.foreign.inspection import inspect
from deltactl.recording.foreign.mapping import load_mapping
from tests.rigs.in_process import called

Capture = pytest.CaptureFixture[str]
N = 400
T_S = 0.05 * np.arange(N)
AXES = {
    f"{axis}": 0.9 * np.sin(0.7 * T_S + n) + 0.2 * np.sin(1.9 * T_S) for n, axis in enumerate("ABC")
}


def write(path: Path, columns: dict[str, np.ndarray], rows: int = N) -> Path:  # type: ignore[type-arg]
    table = np.stack(list(columns.values()), axis=1)[:rows]
    np.savetxt(path, table, "%.6g", ",", header=",".join(columns), comments="")
    return path


def moved(names: str, labels: tuple[str, ...]) -> dict[str, np.ndarray]:  # type: ignore[type-arg]
    """Commands, readings and efforts of axes; the velocity is of the first alone."""
    columns = {"time_s": T_S}
    for label, asked in zip(labels, AXES.values(), strict=False):
        seen = np.interp(T_S - 0.1, T_S, asked)
        columns[names.format(label, "ActualPosition")] = seen
        if label == labels[0]:
            columns[names.format(label, "ActualVelocity")] = np.gradient(seen, T_S)
        columns[names.format(label, "SetPosition")] = asked
        columns[names.format(label, "Current")] = np.cos(T_S)
    return columns


def label_of(column: str, labels: tuple[str, ...]) -> str:
    return next(one for one in labels if one in column.replace(".", "_").split("_"))


@pytest.mark.parametrize(
    ("names", "labels"),
    [
        ("{}_{}", ("X", "Y", "S")),
        ("{}.{}", ("left", "right")),
        ("{}_{}", ("Axis1", "Axis2")),
        ("{1}_{0}", ("X", "Y")),
        ("{1}_{0}", ("1", "2")),
    ],
)
@pytest.mark.parametrize("chosen", [None, 0, -1])
def test_columns_are_of_the_axis_whose_position_it_is(
    tmp_path: Path, names: str, labels: tuple[str, ...], chosen: int | None
) -> None:
    path = write(tmp_path / "log.csv", moved(names, labels))
    said = []
    if chosen is not None:
        said = [f"position={names.format(labels[chosen], 'ActualPosition')}"]
    found = inspect(path, load_mapping(None, said))
    read = {one.name: one.source for one in found.guesses.values() if one.role != "t"}
    assert {"position", "command"} <= read.keys()
    assert len({label_of(source, labels) for source in read.values()}) == 1, read
    if chosen is not None:
        assert label_of(read["position"], labels) == labels[chosen]


def test_an_effort_beside_a_command_is_read_only_with_an_inertia(
    tmp_path: Path, capsys: Capture
) -> None:
    asked = 30.0 * AXES["A"]
    seen = np.interp(T_S - 0.1, T_S, asked)
    columns = {"Zeit [s]": T_S, "Soll [mm]": asked, "Ist [mm]": seen, "Strom [V]": np.cos(T_S)}
    path = write(tmp_path / "log.csv", columns)
    lines = called(["inspect", path], capsys).stdout.splitlines()
    init = next(line for line in lines if "deltactl init axis" in line)
    command = next(line for line in lines if "deltactl diagnose" in line)
    assert ("--inertia" in init) == ("effort=Strom" in command)
    assert any("--set effort=Strom" in line and "--inertia" in line for line in lines)


@pytest.mark.parametrize(("rows", "short"), [(39, True), (40, False)])
def test_too_few_rows_are_seen_before_a_diagnosis(
    tmp_path: Path, capsys: Capture, rows: int, short: bool
) -> None:
    asked = AXES["A"]
    columns = {"t": T_S, "command": asked, "position": np.interp(T_S - 0.1, T_S, asked)}
    path = write(tmp_path / "log.csv", columns, rows)
    found = json.loads(called(["inspect", path, "--json"], capsys).stdout)[0]
    assert short == any("40" in one and "39" in one for one in found["warnings"])


def test_a_table_of_no_machine_is_refused_without_a_way_round(
    tmp_path: Path, capsys: Capture
) -> None:
    path, robot = tmp_path / "weather.csv", tmp_path / "axis.yaml"
    rows = [f"2026-01-01 00:{n // 60:02d}:{n % 60:02d},{20 + n % 3},anna" for n in range(200)]
    path.write_text("\n".join(["date,temperature_C,operator", *rows]) + "\n")
    called(["init", "axis", robot, "--motion", "rotary", "--zero", "absolute"], capsys)
    made = called(["diagnose", path, "--robot", robot], capsys)
    assert made.returncode == 2
    assert "no position or command" in made.stderr
    assert "deltactl inspect" not in made.stderr
    shown = called(["inspect", path], capsys).stdout
    assert "empty cells" not in shown
    assert "nan" not in shown


def test_a_stepper_is_described_with_its_steps_and_gear(tmp_path: Path, capsys: Capture) -> None:
    angle = np.interp(T_S - 0.1, T_S, AXES["A"])
    columns = {"time_s": T_S, "steps": np.round(800 * AXES["A"]), "Encoder [deg]": 57.3 * angle}
    path = write(tmp_path / "log.csv", columns)
    lines = called(["inspect", path], capsys).stdout.splitlines()
    words = next(shlex.split(line) for line in lines if "--drive stepper" in line)
    given = {"STEPS": "200x16", "GEAR": "5:1", "log-robot.yaml": str(tmp_path / "table.yaml")}
    init = [given.get(word, word) for word in words[words.index("init") :]]
    typed = [*init, "--zero", "absolute"] if "--zero" not in init else init
    assert called(typed, capsys).returncode == 0
    half = ["12339.5" if word == "200x16" else word for word in typed]
    made = called([*half, "--force"], capsys)
    assert made.returncode == 2
    assert "--microsteps-per-rev" in made.stderr
    assert "whole number" in made.stderr


def test_a_table_of_others_is_corrected_by_the_same_options(
    tmp_path: Path, capsys: Capture
) -> None:
    robot = Path(__file__).parents[2] / "config" / "zhao-2023.yaml"
    columns = {"Zeit": 1e3 * T_S}
    for n, asked in enumerate(AXES.values(), 1):
        columns |= {f"eins{n}": 10.0 * asked, f"zwei{n}": 10.0 * asked}
    path = write(tmp_path / "log.csv", columns, 12)
    read = ["t=Zeit[ms]"]
    for n in (1, 2, 3):
        read += [f"command_{n}=eins{n}[deg]", f"theta_{n}=zwei{n}[deg]"]
    typed = ["correct", path, "--robot", robot, "--out", tmp_path / "out.yaml", "--no-train"]
    sets = [word for one in read for word in ("--set", one)]
    made = called([*typed, *sets], capsys)
    assert "12 samples" in made.stderr, "its columns are read, and are too short"
    mapping = tmp_path / "columns.yaml"
    mapping.write_text("columns: {t: {from: Uhr}}\n")
    made = called([*typed, "--columns", mapping], capsys)
    assert made.returncode == 2
    assert "Uhr" in made.stderr


@pytest.mark.parametrize(
    ("stem", "unit"), [("X_{}Position", "mm"), ("pos_{}_y", "mm"), ("joint_{}_z", "deg")]
)
def test_an_axis_called_x_y_or_z_slides_unless_it_is_a_joint(
    tmp_path: Path, stem: str, unit: str
) -> None:
    asked = 103.7 * AXES["A"]
    seen = np.interp(T_S - 0.1, T_S, asked)
    columns = {"t": T_S, stem.format("Set"): asked, stem.format("Actual"): seen}
    found = inspect(write(tmp_path / "log.csv", columns))
    assert {one.unit for one in found.guesses.values() if one.role != "t"} == {unit}
    assert found.motion == ("linear" if unit == "mm" else "rotary")


def test_an_axis_whose_reading_is_its_command_is_not_the_one_to_look_at(tmp_path: Path) -> None:
    columns = moved("{}_{}", ("X", "Y"))
    columns["X_ActualPosition"] = columns["X_SetPosition"]
    del columns["time_s"]
    columns = {name: 50.0 * values for name, values in columns.items()}
    found = inspect(write(tmp_path / "log.csv", columns))
    read = {one.name: one.source for one in found.guesses.values()}
    assert (read["position"], read["command"]) == ("Y_ActualPosition", "Y_SetPosition")
    own = load_mapping(None, ["position=X_ActualPosition"])
    assert "velocity" not in {
        one.name for one in inspect(tmp_path / "log.csv", own).guesses.values()
    }
