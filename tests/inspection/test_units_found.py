"""Units that a heading or a slope says are used, and another one is refused with what to write."""

from __future__ import annotations

import math
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from deltactl.diagnosis.admission.axis_match import check_velocity
from deltactl.foundation.errors import ConfigError, RecordingError
from deltactl.recording.foreign.doubts import other_motion, slope_ratio
from deltactl.recording.foreign.inspection import inspect
from deltactl.recording.foreign.mapping import load_mapping
from deltactl.recording.foreign.reading import read_mapped
from deltactl.recording.tables.flat import from_columns
from tests.rigs.owners_words import owner_says

Deltactl = Callable[..., subprocess.CompletedProcess[str]]
T_S = 0.01 * np.arange(900)
ANGLE = 0.8 * np.sin(2.0 * T_S) + 0.3 * np.sin(3.1 * T_S)
SPEED = 1.6 * np.cos(2.0 * T_S) + 0.93 * np.cos(3.1 * T_S)
CURRENT = np.sign(SPEED) + 0.1 * np.sin(9.0 * T_S)


def write(path: Path, heading: str, *columns: np.ndarray) -> Path:
    rows = "".join(
        ",".join(f"{cell:.6f}" for cell in row) + "\n" for row in np.stack(columns, axis=1)
    )
    path.write_text(f"{heading}\n{rows}", encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("heading", "angle", "speed", "option"),
    [
        ("t_ms,q6_deg,dq6,I6_A", 180 / math.pi, 180 / math.pi, "velocity=dq6[deg/s]"),
        ("t_ms,q6_deg,dq6,I6_A", 180 / math.pi, 1.0, "velocity=dq6[rad/s]"),
        ("t_ms,q6_deg,velocity,I6_A", 180 / math.pi, 30 / math.pi, "velocity=velocity[rpm]"),
        ("t_ms,x_mm,speed,I6_A", 1000.0, 1000.0, "velocity=speed[mm/s]"),
    ],
)
def test_the_unit_of_a_slope_follows_from_its_size(
    tmp_path: Path, heading: str, angle: float, speed: float, option: str
) -> None:
    path = write(tmp_path / "a.csv", heading, 1e3 * T_S, angle * ANGLE, speed * SPEED, CURRENT)
    found = inspect(path)
    assert option in found.options
    read = read_mapped(path, load_mapping(None, owner_says(found)))
    np.testing.assert_allclose(read.column("velocity"), SPEED, atol=1e-4)


def test_a_stated_unit_that_the_slope_denies_is_warned_of(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", "t,q_rad,dq [deg/s],I", T_S, ANGLE, SPEED, CURRENT)
    assert any("does not go with deg/s" in warning for warning in inspect(path).warnings)


@pytest.mark.parametrize("noise", [0.0, 3e-3])
@pytest.mark.parametrize("factor", [1.0, 180 / math.pi, 1e-3, -1.0])
def test_the_factor_is_told_through_noise_rounding_and_gaps(noise: float, factor: float) -> None:
    t_s = T_S + np.where(T_S > 4.0, 30.0, 0.0)
    angle = np.round(ANGLE + noise * np.random.default_rng(1).standard_normal(len(T_S)), 3)
    ratio = slope_ratio(t_s, angle, factor * SPEED)
    assert ratio == pytest.approx(factor, rel=0.05)


def test_what_is_no_slope_has_no_factor() -> None:
    assert slope_ratio(T_S, ANGLE, np.random.default_rng(2).standard_normal(len(T_S))) is None


@pytest.mark.parametrize(
    ("position", "velocity", "says"),
    [
        (1.0, 180 / math.pi, r"57\.3 times .*velocity=COLUMN\[deg/s\]"),
        (1.0, 1000.0, r"1e\+03 times .*velocity=COLUMN\[mm/s\]"),
        (180 / math.pi, 1.0, r"0\.0175 times .*position=COLUMN\[deg\]"),
        (1.0, -20.0, r"-20 times .*velocity=COLUMN\*-0\.05"),
    ],
)
def test_a_velocity_in_another_unit_is_refused_with_what_to_write(
    position: float, velocity: float, says: str
) -> None:
    named = {"t": T_S, "position": position * ANGLE, "velocity": velocity * SPEED}
    with pytest.raises(RecordingError, match=says) as caught:
        check_velocity([from_columns(named, "a.csv")])
    assert "\n" not in str(caught.value)


def test_a_velocity_in_the_unit_of_its_position_passes() -> None:
    check_velocity([from_columns({"t": T_S, "position": ANGLE, "velocity": 1.05 * SPEED}, "a")])


def test_the_unit_in_the_heading_counts_unless_a_factor_is_given(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", "t,Ist [deg],Soll (deg)", T_S, ANGLE, ANGLE)
    told: list[str] = []
    read = read_mapped(path, load_mapping(None, ["position=Ist", "command=Soll"]), told.append)
    np.testing.assert_allclose(read.column("position"), np.radians(ANGLE), atol=1e-6)
    np.testing.assert_allclose(read.column("command"), np.radians(ANGLE), atol=1e-6)
    assert told == [
        "a.csv: position is read in deg, as the heading 'Ist [deg]' says",
        "a.csv: command is read in deg, as the heading 'Soll (deg)' says",
    ]
    for option, factor in (("position=Ist[rad]*1", 1.0), ("position=Ist*0.5", 0.5)):
        other = read_mapped(path, load_mapping(None, [option]), told.append)
        np.testing.assert_allclose(other.column("position"), factor * ANGLE, atol=1e-6)
    assert len(told) == 2


def test_degrees_and_milliseconds_that_nobody_said_are_asked_about(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", "tick,q", np.round(1e3 * T_S), 100.0 * ANGLE)
    told: list[str] = []
    read_mapped(path, load_mapping(None, ["t=tick", "position=q"]), told.append)
    assert [line.rsplit("--set ")[1] for line in told] == ['"t=tick[ms]"', '"position=q[deg]"']
    read_mapped(path, load_mapping(None, ["t=tick[ms]", "position=q[deg]"]), told.append)
    read_mapped(path, load_mapping(None, ["t=tick*0.001", "position=q*0.0001"]), told.append)
    assert len(told) == 2


def test_units_of_speed_and_names_of_columns_are_listed(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", "t,q,dq", T_S, ANGLE, 1e3 * SPEED)
    read = read_mapped(path, load_mapping(None, ["position=q", "velocity=dq[mm/s]"]))
    np.testing.assert_allclose(read.column("velocity"), SPEED, atol=1e-6)
    with pytest.raises(RecordingError, match=r"'deg/sec' is not known; .*deg/s"):
        read_mapped(path, load_mapping(None, ["velocity=dq[deg/sec]"]))
    with pytest.raises(ConfigError, match="unit of velocity, not of position"):
        load_mapping(None, ["position=q[deg/s]"])
    with pytest.raises(ConfigError, match=r"one of .*position, command, effort, velocity, load"):
        load_mapping(None, ["pos=q"])


def test_the_command_line_says_which_unit_the_heading_gave(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    write(tmp_path / "a.csv", "t,Ist [deg],Soll [deg]", T_S, ANGLE, 0.0 * ANGLE)
    (tmp_path / "axis.yaml").write_text("kind: servo_axis\nname: mine\nmotion: rotary\n")
    said = deltactl(
        "diagnose", "a.csv", "--robot", "axis.yaml", "--set", "position=Ist", "--set",
        "command=Soll", status=2,
    ).stderr  # fmt: skip
    assert "position is read in deg, as the heading 'Ist [deg]' says" in said


def test_the_twin_of_a_command_in_counts_is_the_position_in_counts(tmp_path: Path) -> None:
    counts = [np.round(2048 + 300 * part) for part in (ANGLE, np.roll(ANGLE, 3))]
    path = write(tmp_path / "a.csv", "ts,cmd_counts,pos_counts,pull_Nm", T_S, *counts, CURRENT)
    found = inspect(path)
    assert (found.guesses["pos_counts"].name, found.kind) == ("position", "servo_axis")
    assert found.guesses["pos_counts"].scale == found.guesses["cmd_counts"].scale != 1.0
    assert "may be load or effort: --set load=pull_Nm" in found.unused("pull_Nm")
    assert found.unused("note") == "kept, not used"


def test_the_advice_never_names_a_load_as_the_position(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", "ts,cmd,pull_Nm", T_S, ANGLE, CURRENT)
    assert "--set position=COLUMN" in inspect(path).kind_why


@pytest.mark.parametrize(
    ("unit", "motion", "wrong"),
    [("mm", "rotary", True), ("deg", "rotary", False), ("deg", "linear", True),
     ("mm", "linear", False), ("1", "rotary", False)],
)  # fmt: skip
def test_a_length_is_no_unit_of_an_axis_that_turns(unit: str, motion: str, wrong: bool) -> None:
    assert bool(other_motion({"t": "ms", "position": unit}, motion)) is wrong


def test_grad_is_degrees_and_said_to_be_doubtful(deltactl, tmp_path) -> None:
    rows = [f"{0.01 * n:.2f},{n % 90},{n % 90 + 0.1}" for n in range(500)]
    for unit, doubtful in (("grad", True), ("Grad", True), ("deg", False)):
        heading = f"t [s],Soll [{unit}],Winkel [{unit}]"
        (tmp_path / "log.csv").write_text("\n".join([heading, *rows]) + "\n")
        done = deltactl("inspect", "log.csv")
        assert "position=Winkel[deg]" in done.stdout.replace("\n", "")
        assert ("grad is read as degrees" in done.stdout) == doubtful
