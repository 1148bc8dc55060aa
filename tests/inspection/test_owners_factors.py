"""What one of a column is, where only its owner knows it: pulses, counts of a voltage, steps."""

from __future__ import annotations

import shlex
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import deltactl as dc
from deltactl.foundation.errors import ConfigError, RecordingError
from deltactl.recording.foreign.inspection import inspect
from deltactl.recording.foreign.mapping import load_mapping
from deltactl.recording.foreign.reading import read_mapped
from tests.inspection.test_printed_commands import printed

Deltactl = Callable[..., subprocess.CompletedProcess[str]]
T_S = np.arange(0.0, 30.0, 0.02)
WAY = 0.7 * np.sin(0.8 * T_S) + 0.3 * np.sin(1.9 * T_S + 0.4)
LATE = np.interp(T_S - 0.06, T_S, WAY)
NOISE = np.random.default_rng(2).normal(0.0, 1.0, len(T_S))


def write(path: Path, heading: str, *columns: np.ndarray, digits: int = 2) -> Path:
    table = np.stack([1e3 * T_S, *columns], axis=1)
    np.savetxt(path, table, f"%.{digits}f", ",", header=heading, comments="")
    return path


def servo(path: Path, heading: str, per_us: float = 0.28) -> Path:
    """A hobby servo: whole microseconds, and what was read of it."""
    pulses = np.round(1500.0 + 650.0 * WAY)
    read = 512.0 + 650.0 * per_us * LATE + 0.4 * NOISE
    return write(path, f"time_ms,{heading}", pulses, np.round(read), digits=0)


@pytest.mark.parametrize("per_us", [0.28, -0.4])
@pytest.mark.parametrize(
    "heading",
    ["pulse_us,pot", "servo_pwm,adc", "us,analog", "Pulse width [us],A0", "pwm,potentiometer"],
)
def test_pulses_command_a_hobby_servo(tmp_path: Path, heading: str, per_us: float) -> None:
    found = inspect(servo(tmp_path / "log.csv", heading, per_us))
    names = {guess.name: name for name, guess in found.guesses.items()}
    assert [names["command"], names["position"]] == heading.split(",")
    assert (found.kind, found.motion, found.zero) == ("servo_axis", "rotary", "arbitrary")
    assert {name: one.word for name, one in found.factors.items()} == {
        "command": "DEG_PER_US", "position": "DEG_PER_COUNT",
    }  # fmt: skip
    assert ("negative" in found.factors["position"].says) == (per_us < 0.0)


@pytest.mark.parametrize(
    ("heading", "asked", "read", "word"),
    [
        ("servo_angle,pot", np.round(90.0 + 60.0 * WAY), 512.0 + 180.0 * LATE, "DEG_PER_COUNT"),
        ("target_mm,A1", 50.0 + 30.0 * WAY, 512.0 - 300.0 * LATE, "MM_PER_COUNT"),
        ("goal_deg,adc", 60.0 * WAY, 2048.0 + 700.0 * LATE, "DEG_PER_COUNT"),
    ],
)
def test_a_potentiometer_is_read_in_counts_of_its_own(
    tmp_path: Path, heading: str, asked: np.ndarray, read: np.ndarray, word: str
) -> None:
    found = inspect(write(tmp_path / "log.csv", f"ms,{heading}", asked, np.round(read)))
    names = {guess.name: name for name, guess in found.guesses.items()}
    assert [names["command"], names["position"]] == heading.split(",")
    assert found.factors["position"].word == word
    known = found.guesses[names["command"]].why != "moves like pot, smoother or earlier"
    assert ("in this recording" in found.factors["position"].says) == known
    assert found.zero == "arbitrary"


def test_volts_of_a_potentiometer(tmp_path: Path) -> None:
    pulses, volts = 1500.0 + 400.0 * WAY, 1.65 + 0.4 * LATE
    found = inspect(write(tmp_path / "log.csv", "ms,pulse_us,pot_V", pulses, volts, digits=4))
    assert found.factors["position"].word == "DEG_PER_VOLT"


@pytest.mark.parametrize(
    ("heading", "way", "each", "word"),
    [
        ("setpoint_deg,encoder_counts", 700.0, 8192.0 / 360.0, "DEG_PER_COUNT"),
        ("goal [rad],enc_ticks", 6.0, 2000.0 / 2.0 / np.pi, "DEG_PER_COUNT"),
        ("target_mm,encoder", 90.0, 200.0, "MM_PER_COUNT"),
    ],
)
def test_counts_of_an_encoder_beside_a_command_with_a_unit(
    tmp_path: Path, heading: str, way: float, each: float, word: str
) -> None:
    read = np.round(each * way * LATE)
    path = write(tmp_path / "log.csv", f"ms,{heading}", way * WAY, read, digits=3)
    found = inspect(path)
    assert found.kind == "servo_axis"
    assert found.factors["position"].word == word
    both = read_mapped(path, found.mapping).columns
    assert np.ptp(both["position"]) == pytest.approx(np.ptp(both["command"]), rel=0.02)


def test_an_encoder_beside_pulses_keeps_its_counts(tmp_path: Path) -> None:
    found = inspect(servo(tmp_path / "log.csv", "pulse_us,encoder", 0.9))
    assert list(found.factors) == ["command"]
    assert (found.zero, found.guesses["encoder"].unit) == ("arbitrary", "rad")


def test_pulses_beside_an_angle_with_a_unit(tmp_path: Path) -> None:
    found = inspect(write(tmp_path / "log.csv", "ms,pwm_us,roll_deg", 1500 + 500 * WAY, 45 * LATE))
    assert list(found.factors) == ["command"]
    assert "position=roll_deg[deg]" in found.options


@pytest.mark.parametrize(
    ("heading", "pulses"),
    [
        ("pwm,angle_deg", 120.0 * np.gradient(WAY, T_S)),  # a duty
        ("pulse_us,angle_deg", np.round(1500.0 + 400.0 * np.gradient(WAY, T_S))),  # a speed
        ("servo_pos,goal", np.round(1500.0 + 500.0 * WAY)),  # counts that are called a position
    ],
)
def test_what_nothing_follows_is_no_command_in_pulses(
    tmp_path: Path, heading: str, pulses: np.ndarray
) -> None:
    found = inspect(write(tmp_path / "log.csv", f"t_ms,{heading}", pulses, 40.0 * WAY))
    assert "DEG_PER_US" not in {one.word for one in found.factors.values()}


def test_the_printed_commands_run_once_the_numbers_are_said(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    servo(tmp_path / "log.csv", "pulse_us,pot")
    shown = deltactl("inspect", "log.csv")
    for word in ("DEG_PER_US", "DEG_PER_COUNT"):
        assert f"  {word}: degrees for " in shown.stdout
    assert deltactl(*printed(shown, "describe the machine:")).returncode == 0
    words = printed(shown)
    assert "put a number for DEG_PER_" in deltactl(*words, status=2).stderr
    plain = deltactl("diagnose", "log.csv", "--robot", "log-robot.yaml", status=2)
    assert "its owner has to say" in plain.stderr
    said = {"DEG_PER_US": "0.09", "DEG_PER_COUNT": "0.3214"}
    for word, number in said.items():
        words = [one.replace(word, number) for one in words]
    assert "follows late" in deltactl(*words).stdout
    with pytest.raises(ConfigError, match="put a number for DEG_PER_US"):
        dc.read(tmp_path / "log.csv", {"command": "pulse_us[deg]*DEG_PER_US"})


@pytest.mark.parametrize(
    ("heading", "size"),
    [
        ("steps,mm", 1.0), ("steps_cmd,caliper_mm", 1.0), ("step_count,dial [mm]", 1.0),
        ("target_steps,um", 1e3), ("pulses,inch", 1 / 25.4), ("cmd_counts,scale_cm", 0.1),
        ("steps,gauge [in]", 1 / 25.4),
    ],
)  # fmt: skip
def test_a_length_in_the_heading_makes_steps_those_of_a_slide(
    tmp_path: Path, heading: str, size: float
) -> None:
    read = 80.0 * LATE + 0.01 * NOISE
    steps = np.round(8000.0 * WAY)
    found = inspect(write(tmp_path / "log.csv", f"ms,{heading}", steps, size * read, digits=4))
    assert (found.kind, found.motion) == ("servo_axis", "linear")
    name = heading.partition(",")[0]
    assert f"command={name}[mm]*MM_PER_STEP" in found.options
    assert "in this recording 0.00997" in found.factors["command"].says
    command = read_mapped(tmp_path / "log.csv", found.mapping).columns["command"]
    assert np.ptp(command) == pytest.approx(np.ptp(0.08 * WAY), rel=1e-2)


@pytest.mark.parametrize("heading", ["steps,deg", "steps_cmd,protractor_deg", "pulses,degrees"])
def test_an_angle_in_the_heading_makes_them_those_of_a_gear(tmp_path: Path, heading: str) -> None:
    steps = np.round(8000.0 * WAY)
    found = inspect(write(tmp_path / "log.csv", f"ms,{heading}", steps, 900.0 * LATE))
    assert found.kind == "stepper_axis"
    read = heading.partition(",")[2]
    assert f"theta_1={read}[deg]" in found.options
    assert not found.factors


def test_whole_degrees_that_a_heading_says_are_no_counts(tmp_path: Path) -> None:
    path = write(tmp_path / "log.csv", "ms,goal_deg,angle_deg", 900 * WAY, 900 * LATE, digits=0)
    found = inspect(path)
    assert np.ptp(read_mapped(path, found.mapping).columns["position"]) > 20.0
    bare = write(tmp_path / "bare.csv", "ms,goal,angle", 900 * WAY, 900 * LATE, digits=0)
    in_degrees = load_mapping(None, ["t=ms[ms]", "position=angle[deg]"])
    with pytest.raises(RecordingError, match="look like counts"):
        read_mapped(bare, in_degrees)


PLACES = np.repeat([50.0, 100.0, 300.0, 200.0, 800.0, 500.0], 9)
READ = np.round(1.02 * PLACES + 4.0 + NOISE[: len(PLACES)])


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
@pytest.mark.parametrize("size", [1.0, 1e-3])
def test_places_and_readings_without_names_are_a_distance_sensor(
    tmp_path: Path, order: tuple[int, int], size: float
) -> None:
    path = tmp_path / "log.csv"
    np.savetxt(path, size * np.stack([PLACES, READ])[list(order)].T, "%.4g", ",")
    found = inspect(path)
    assert found.kind == "range_sensor"
    assert found.guesses[f"column_{order.index(0) + 1}"].name == "distance"
    assert not any("rate_hz" in one for one in [*found.warnings, *found.options])


@pytest.mark.parametrize(
    ("said", "read", "remedy"),
    [
        ("distance=72", "range=seen[mm]", "distance=72[mm]"),
        ("distance=7.2", "range=seen[mm]", "distance=7.2[cm]"),
        ("distance=0.072", "range=seen[m]", "range=seen[mm]"),
    ],
)
def test_one_distance_in_another_unit_is_refused(
    tmp_path: Path, said: str, read: str, remedy: str
) -> None:
    path = write(tmp_path / "log.csv", "ms,seen", 75.0 + NOISE)
    known = load_mapping(None, ["t=ms[ms]", said, read])
    for look in (lambda: read_mapped(path, known), lambda: inspect(path, known)):
        with pytest.raises(RecordingError) as caught:
            look()
        assert str(caught.value).endswith(f'type --set "{remedy}"')
    right = load_mapping(None, ["t=ms[ms]", "distance=72[mm]", "range=seen[mm]"])
    assert inspect(path, right).kind == "range_sensor"
    assert shlex.join(inspect(path, right).options).endswith("distance=0.072")
