"""Tables as newcomers bring them: what they are is found, or said to be unknown."""

from __future__ import annotations

import shlex
import subprocess
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import deltactl as dc
from deltactl.foundation.errors import ConfigError, RecordingError, RefusedRecording
from deltactl.recording.foreign.inspection import inspect
from deltactl.recording.foreign.mapping import load_mapping
from deltactl.recording.foreign.reading import read_mapped
from tests.inspection.test_printed_commands import put

Deltactl = Callable[..., subprocess.CompletedProcess[str]]
T_S = np.arange(0.0, 15.0, 0.02)
ASKED_MM = 100.0 + 60.0 * np.sin(0.5 * T_S) + 15.0 * np.sin(1.7 * T_S)
NOISE = np.random.default_rng(5).normal(0.0, 0.02, (6, len(T_S)))
SLIDE = "kind: servo_axis\nname: slide\nmotion: linear\n"


def write(path: Path, head: str, *columns: np.ndarray, separator: str = ",") -> Path:
    rows = np.stack(columns, axis=1)
    np.savetxt(path, rows, "%.5f", separator, header=head, comments="", encoding="utf-8")
    return path


@pytest.fixture
def stepper(tmp_path: Path) -> Path:
    """A slide with its steps, its command and its encoder, which reads 1.5 % too far."""
    head = "Time (s),Step count,Target position (mm),Encoder (mm)"
    steps = np.round(80.0 * ASKED_MM)
    return write(tmp_path / "slide.csv", head, T_S, steps, ASKED_MM, 1.015 * ASKED_MM + NOISE[0])


def test_a_length_beside_steps_and_a_command_is_no_angle(stepper: Path) -> None:
    found = inspect(stepper)
    assert (found.kind, found.motion) == ("servo_axis", "linear")
    read = read_mapped(stepper, found.mapping)
    assert np.ptp(read.columns["position"]) == pytest.approx(
        1.015 * np.ptp(ASKED_MM) / 1e3, rel=2e-3
    )
    assert not {"theta_1", "steps_1"} & read.columns.keys()


@pytest.mark.parametrize(
    "option", ["theta_1=Encoder[mm]", "theta_1=Encoder", "theta_1=Step count[m]"]
)
def test_a_length_is_not_read_as_an_angle(stepper: Path, option: str) -> None:
    with pytest.raises(RecordingError, match="theta_1 is an angle"):
        read_mapped(stepper, load_mapping(None, ["t=Time", option]))


def test_an_angle_is_not_read_as_a_length(tmp_path: Path) -> None:
    path = write(tmp_path / "far.csv", "t,phi_deg", T_S, ASKED_MM)
    with pytest.raises(RecordingError, match="range is a length"):
        read_mapped(path, load_mapping(None, ["range=phi_deg[deg]"]))


@pytest.mark.study
def test_the_command_of_a_wide_table_without_heading_runs(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    """It names the columns that are used; all names together may be longer than a file's."""
    asked = np.radians(ASKED_MM - 100.0)
    still = [np.full(len(T_S), float(n)) for n in range(40)]
    write(tmp_path / "wide.txt", "", T_S, asked, asked + 1e-2 * NOISE[0], *still)
    text = (tmp_path / "wide.txt").read_text().lstrip("\n")
    (tmp_path / "wide.txt").write_text(text)
    shown = deltactl("inspect", "wide.txt").stdout.splitlines()
    (tmp_path / "wide-robot.yaml").write_text("kind: servo_axis\nname: arm\nmotion: rotary\n")
    (typed,) = [one.split(":", 1)[1] for one in shown if one.startswith("diagnose it:")]
    assert len(typed) < 200
    deltactl(*put(shlex.split(typed)[1:], "rad", "rotary"))
    heading = ",".join(["t", "command", "position", *(f"column_{n}" for n in range(4, 44))])
    assert len(heading) > 300
    deltactl(*shlex.split(typed)[1:5], "--set", f"heading={heading}")


def test_a_commanded_speed_is_no_command_of_a_position(tmp_path: Path) -> None:
    """A ramp goes like a ramp; times that stand still now and then make no numpy warning."""
    stamped = np.maximum(T_S - 0.02, 0.0)
    place = 5.5 + 0.002 * T_S**2
    torque = 0.4 * np.sign(np.gradient(place)) + np.sin(3.0 * T_S) + NOISE[0]
    head = "TIME,POSITION,VELOCITY,TORQUE,CONTROL_VELOCITY"
    path = write(tmp_path / "log.csv", head, stamped, place, 0.004 * T_S, torque, 0.004 * T_S)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = inspect(path)
    assert "CONTROL_VELOCITY" not in found.guesses
    assert found.guesses["POSITION"].name == "position"


def test_joints_of_a_wide_table_without_names_are_no_pair(tmp_path: Path) -> None:
    """Two that move alike, one of them seven times as far and elsewhere, are two joints."""
    sway = np.sin(0.4 * T_S)
    others = [np.cos((2.3 + n) * T_S) + NOISE[n] for n in range(6)]
    columns = [T_S, *others[:3], -1.4 + 0.007 * sway, -0.87 + 0.001 * sway, *others[3:]]
    path = write(tmp_path / "log.txt", "", *columns)
    path.write_text(path.read_text().lstrip("\n"))
    assert not {"column_5", "column_6"} <= inspect(path).guesses.keys()


@pytest.mark.parametrize("name", ["Abstand [mm]", "tof_mm"])
def test_the_only_distance_that_follows_a_command_is_the_reading(tmp_path: Path, name: str) -> None:
    head = f"Zeit [ms];Sollwert;{name}"
    path = write(
        tmp_path / "log.csv", head, 1e3 * T_S, ASKED_MM, ASKED_MM + NOISE[0], separator=";"
    )
    found = inspect(path)
    assert found.kind == "servo_axis"
    read = read_mapped(path, found.mapping)
    assert np.ptp(read.columns["command"]) == pytest.approx(np.ptp(ASKED_MM) / 1e3, rel=1e-3)


@pytest.mark.parametrize(
    "head",
    [
        "time,temperature,humidity,pressure,wind_speed",
        "time,temp_actual,temp_setpoint,humidity,wind_direction",
        "time,inside,outside,level,index",
    ],
)
def test_a_table_of_the_weather_is_no_machine(tmp_path: Path, head: str) -> None:
    random = np.random.default_rng(8)
    warm = 15.0 + 5.0 * np.sin(60.0 * T_S / 8000.0) + random.normal(0.0, 0.1, len(T_S))
    slow = [1013.0 + np.cumsum(random.normal(0.0, 0.05, len(T_S))) for _ in range(2)]
    path = write(
        tmp_path / "weather.csv", head, T_S, warm, *slow, random.normal(3.0, 1.0, len(T_S))
    )
    assert inspect(path).kind is None


def test_where_nothing_is_printed_no_printed_command_is_spoken_of(tmp_path: Path) -> None:
    path = write(tmp_path / "one.csv", "d", ASKED_MM)
    found = inspect(path)
    assert found.kind is None
    assert not [one for one in found.warnings if "printed command" in one]
    assert [one for one in found.warnings if "rate_hz" in one]


@pytest.mark.parametrize(("typed", "meant"), [("pos", "position"), ("rate", "rate_hz")])
def test_the_name_that_was_meant_comes_first(typed: str, meant: str) -> None:
    with pytest.raises(ConfigError) as failed:
        load_mapping(None, [f"{typed}=angle"])
    says = str(failed.value)
    assert says.index(f"did you mean {meant}?") < says.index("NAME=COLUMN")


def test_a_column_of_times_that_is_there_is_named(tmp_path: Path) -> None:
    path = write(tmp_path / "log.csv", "stamp,angle", T_S, ASKED_MM)
    with pytest.raises(RecordingError, match="'stamp' looks like one"):
        read_mapped(path, load_mapping(None, ["position=angle"]))


def test_python_reads_a_table_as_its_inspection_shows_it(stepper: Path) -> None:
    found = dc.inspect(stepper)
    with pytest.warns(UserWarning, match="read as inspected: columns="):
        plain = dc.read(stepper)
    named = dc.read(stepper, found.columns)
    for name in ("t", "command", "position"):
        np.testing.assert_array_equal(plain[name], named[name])
    assert len(repr(found).splitlines()) < 12
    assert f"columns={found.columns}" in repr(found)
    assert "Step count" in found._repr_html_()


def test_python_names_what_is_wrong_with_a_table_that_nobody_understands(tmp_path: Path) -> None:
    path = write(tmp_path / "one.csv", "d,e", ASKED_MM, NOISE[0])
    with pytest.raises(RecordingError, match="has no column 't'") as failed:
        dc.read(path)
    assert "type:" not in str(failed.value)


def test_a_unit_that_is_missing_is_proposed(tmp_path: Path) -> None:
    path = write(tmp_path / "log.csv", "t,asked,seen_mm", T_S, ASKED_MM, ASKED_MM + NOISE[0])
    read = dc.read(path, {"t": "t", "command": "asked", "position": "seen_mm"})
    with pytest.raises(RefusedRecording, match=r"command looks like mm.*command=COLUMN\[mm\]"):
        dc.diagnose(read, dc.Robot.from_text(SLIDE, "slide.yaml"))


@pytest.mark.study
def test_an_effort_of_the_programs_own_name_is_offered(deltactl: Deltactl, tmp_path: Path) -> None:
    """And the words that are shown make a robot file with which it is used."""
    place = np.sin(0.5 * T_S)
    push = 3.0 * np.gradient(np.gradient(place, T_S), T_S) + 0.2 * np.sign(np.gradient(place))
    write(
        tmp_path / "log.csv", "t,command,position,effort", T_S, place, place + 1e-2 * NOISE[0], push
    )
    shown = deltactl("inspect", "log.csv").stdout.splitlines()
    (line,) = [one for one in shown if "to use the effort" in one]
    options = [word.strip(",") for word in line.split() if word.startswith("--")]
    (init,) = [one.split(":", 1)[1] for one in shown if one.startswith("describe the machine:")]
    sizes = [word for option in options for word in (option, "3")]
    deltactl(*put(shlex.split(init)[1:], "rad", "rotary"), *sizes)
    (typed,) = [one.split(":", 1)[1] for one in shown if one.startswith("diagnose it:")]
    command = put(shlex.split(typed)[1:], "rad", "rotary")
    assert "effort is not used" not in deltactl(*command).stderr


def test_joints_of_a_whole_arm_are_offered_together(tmp_path: Path) -> None:
    names = [f"{what}_{n}" for what in ("theta", "effort") for n in range(1, 7)]
    columns = [np.sin((0.3 + 0.1 * n) * T_S) + NOISE[n % 6] for n in range(12)]
    path = write(tmp_path / "arm.csv", ",".join(["t", *names]), T_S, *columns)
    (says,) = [one for one in inspect(path).warnings if "more joints than one" in one]
    assert "deltactl init chain" in says


def test_places_alone_are_asked_for_the_motors(tmp_path: Path) -> None:
    """Not for a position, of which there are three."""
    turn = 100.0 * np.cos(T_S), 100.0 * np.sin(T_S), NOISE[0] - 300.0
    found = inspect(write(tmp_path / "places.csv", "X,Y,Z", *turn))
    assert found.kind is None
    assert "command_1" in found.kind_why
    assert "position=" not in found.kind_why
