"""Tables with other separators, without times, or of another machine, as they are diagnosed."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from deltactl.foundation.errors import RecordingError
from deltactl.recording.foreign.inspection import inspect
from deltactl.recording.foreign.mapping import load_mapping
from deltactl.recording.foreign.reading import read_mapped
from tests.rigs.owners_words import owner_says

Deltactl = Callable[..., subprocess.CompletedProcess[str]]
T_S = 0.01 * np.arange(800)
ASKED = 0.8 * np.sin(2.0 * T_S) + 0.3 * np.sin(3.1 * T_S)
NOISE = np.random.default_rng(2).standard_normal(len(T_S))
SEEN = np.interp(T_S - 0.05, T_S, ASKED) + 0.002 * NOISE
TRUE_MM = np.arange(30.0, 310.0, 8.0)
READ_MM = np.round(1.02 * TRUE_MM + 4.0 + NOISE[: len(TRUE_MM)])
AXIS = "kind: servo_axis\nname: mine\nmotion: rotary\n"
SENSOR = "kind: range_sensor\nname: mine\n"
OF_A_RULER = ("--set", "distance=Abstand[mm]", "--set", "range=Anzeige[mm]")
WAYS = [(";", ","), ("\t", "."), (" ", "."), ("|", "."), (";", ".")]


def write(
    path: Path, head: list[str], columns: list[np.ndarray], separator: str, decimal: str = "."
) -> Path:
    rows = [
        separator.join(f"{value:.6g}".replace(".", decimal) for value in row)
        for row in np.stack(columns, axis=1)
    ]
    path.write_text("\n".join([separator.join(head), *rows]) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize(("separator", "decimal"), WAYS)
def test_separator_and_decimal_mark_are_found_and_told(
    tmp_path: Path, separator: str, decimal: str
) -> None:
    path = write(tmp_path / "a.csv", ["ms", "q"], [1e3 * T_S, SEEN], separator, decimal)
    told: list[str] = []
    read = read_mapped(path, load_mapping(None, ["t=ms[ms]", "position=q"]), told.append)
    np.testing.assert_allclose(read.column("position"), SEEN, atol=1e-5)
    (line,) = told
    assert line.startswith("a.csv: is read with ")
    assert ("decimal comma" in line) == (decimal == ",")
    options = inspect(path, load_mapping(None, ["position=q"])).options
    assert not [one for one in options if "separator" in one or "decimal" in one]


@pytest.mark.study
def test_a_separator_that_is_said_wins_and_is_printed_back(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", ["ms", "q"], [1e3 * T_S, SEEN], "\t")
    told: list[str] = []
    said = load_mapping(None, ["t=ms[ms]", "position=q", "separator=tab", "decimal=."])
    np.testing.assert_allclose(read_mapped(path, said, told.append).t_s, T_S, atol=1e-6)
    assert told == []
    assert "separator=tab" in inspect(path, said).options


@pytest.mark.parametrize(
    ("found", "said", "says"),
    [
        ("\t", "comma", "separated by tabs: type --set separator=tab in place of separator=comma"),
        (";", "comma", "separated by semicolons: type --set separator=semicolon in place of"),
        (",", ";", "separated by commas: type --set separator=comma in place of"),
        (";", "tab", "separated by semicolons"),
    ],
)
def test_a_wrong_separator_is_named_with_the_right_one(
    tmp_path: Path, found: str, said: str, says: str
) -> None:
    decimal = "," if found == ";" else "."
    path = write(tmp_path / "a.csv", ["Zeit", "Weg (mm)"], [T_S, SEEN], found, decimal)
    options = ["t=Zeit", "position=Weg (mm)", f"separator={said}"]
    with pytest.raises(RecordingError, match=says):
        read_mapped(path, load_mapping(None, options))


@pytest.mark.study
def test_our_names_behind_semicolons_need_no_option(deltactl: Deltactl, tmp_path: Path) -> None:
    write(tmp_path / "a.csv", ["t", "command", "position"], [T_S, ASKED, SEEN], ";", ",")
    (tmp_path / "axis.yaml").write_text(AXIS)
    done = deltactl("diagnose", "a.csv", "--robot", "axis.yaml")
    assert done.stderr == "a.csv: is read with semicolons between, decimal comma\n"


def test_a_sensor_beside_a_ruler_needs_no_times(deltactl: Deltactl, tmp_path: Path) -> None:
    number = np.arange(len(TRUE_MM)) + 1.0
    head = ["Nr", "Abstand (mm)", "Anzeige (mm)"]
    write(tmp_path / "tof.csv", head, [number, TRUE_MM, READ_MM], "\t")
    (tmp_path / "tof.yaml").write_text(SENSOR)
    shown = deltactl("inspect", "tof.csv")
    assert "look here" not in shown.stdout + shown.stderr
    assert "without times, which a distance sensor does not need" in shown.stdout
    assert "t=Nr" not in shown.stdout
    done = deltactl("diagnose", "tof.csv", "--robot", "tof.yaml", *OF_A_RULER)
    assert done.stderr.splitlines() == [
        "tof.csv: is read with tabs between, decimal point",
        "tof.csv: has no times, and a distance sensor needs none: where a time is"
        " reported, one row is one second",
    ]
    write(tmp_path / "ours.csv", ["distance", "range"], [1e-3 * TRUE_MM, 1e-3 * READ_MM], ",")
    assert "one row is one second" in deltactl("diagnose", "ours.csv", "--robot", "tof.yaml").stderr


def test_of_other_machines_it_is_said_what_to_type_for_times(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", ["soll", "ist"], [ASKED, SEEN], ",")
    with pytest.raises(RecordingError, match="--set rate_hz=50 with the rows per second"):
        read_mapped(path, load_mapping(None, ["command=soll", "position=ist"]))
    inspected = inspect(path, load_mapping(None, ["rate_hz=100"]))
    assert "rate_hz=100" in inspected.options
    assert not [one for one in inspected.warnings if "rate_hz" in one]
    read = read_mapped(path, load_mapping(None, owner_says(inspected)))
    np.testing.assert_allclose(read.t_s, T_S)


def test_a_rate_that_is_said_stands_in_for_a_column_called_t(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", ["t", "command", "position"], [T_S**2, ASKED, SEEN], ",")
    read = read_mapped(path, load_mapping(None, ["rate_hz=100"]))
    np.testing.assert_allclose(read.t_s, T_S)


@pytest.mark.study
def test_names_of_ones_own_with_another_machines_file_say_which_machine(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    head = ["Zeit [s]", "Soll [deg]", "Ist [deg]"]
    write(tmp_path / "a.csv", head, [T_S, np.degrees(ASKED), np.degrees(SEEN)], ";", ",")
    (tmp_path / "tof.yaml").write_text(SENSOR)
    says = deltactl("diagnose", "a.csv", "--robot", "tof.yaml", status=2).stderr
    assert says.startswith("deltactl: a.csv: looks like a table of a servo_axis")
    assert "deltactl inspect a.csv" in says
    (tmp_path / "axis.yaml").write_text(AXIS)
    says = deltactl("diagnose", "a.csv", "--robot", "axis.yaml").stderr
    assert "--set t=Zeit --set 'position=Ist[deg]' --set 'command=Soll[deg]'" in says
    write(tmp_path / "b.csv", ["command", "position"], [ASKED, SEEN], ",")
    says = deltactl("diagnose", "b.csv", "--robot", "axis.yaml", status=2).stderr
    assert "--set rate_hz=50 with the rows per second" in says


@pytest.mark.parametrize(("pause_s", "fact"), [(1.5, True), (0.0, False)])
def test_missing_rows_are_a_fact_and_no_warning(tmp_path: Path, pause_s: float, fact: bool) -> None:
    late = np.cumsum(np.where(np.arange(len(T_S)) % 70 == 69, pause_s, 0.0))
    head = ["t", "command", "position"]
    found = inspect(write(tmp_path / "a.csv", head, [50.0 * T_S + late, ASKED, SEEN], ","))
    missing = dict(found.facts).get("missing", "")
    assert missing.startswith("11 steps are longer than usual, up to 2 s: rows are") == fact
    assert not [one for one in found.warnings if "step" in one]
