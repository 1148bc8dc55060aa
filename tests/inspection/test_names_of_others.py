"""Headings as loggers of many makers write them, and columns that only their numbers tell apart."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from deltactl.recording.foreign.found import Inspection
from deltactl.recording.foreign.inspection import inspect
from deltactl.recording.foreign.names import read_name

ROWS = 600
T_S = 0.01 * np.arange(ROWS)
NOISE = np.random.default_rng(3).standard_normal((3, ROWS))
ASKED = 0.8 * np.sin(2.0 * T_S) + 0.3 * np.sin(3.1 * T_S)
SEEN = np.interp(T_S - 0.05, T_S, ASKED) + 0.002 * NOISE[0]


def table(path: Path, **columns: np.ndarray) -> Inspection:
    head = ",".join(name.replace("__", " ") for name in columns)
    rows = np.stack(list(columns.values()), axis=1)
    np.savetxt(path / "log.csv", rows, "%.6f", ",", header=head, comments="", encoding="utf-8")
    return inspect(path / "log.csv")


def taken(found: Inspection) -> dict[str, str]:
    return {guess.name: guess.source for guess in found.guesses.values()}


@pytest.mark.parametrize(
    ("name", "role", "unit"),
    [
        ("Sollwinkel", "command", None), ("Istposition [mm]", "position", "mm"),
        ("Schrittz\u00e4hler", "steps", None), ("Schrittzaehler_mm", "command", "mm"),
        ("targetPos", "command", None), ("ActualPosition", "position", None),
        ("position_r\u00e9elle", "position", None), ("mesur\u00e9", "position", None),
        ("\u00e1ngulo", "position", None), ("axis_1.cmd_pos", "command", None),
        ("RBV", "position", None), ("Motorstrom (A)", "effort", "A"),
        ("Drehzahl [1/min]", "velocity", "rpm"), ("action.elbow_flex.pos", "command", None),
        ("observation.state.elbow_flex.pos", "position", None),
        ("star [\u2033]", "position", "arcsec"),
        ("Abstand (mm)", "distance", "mm"), ("Anzeige (mm)", "range", "mm"),
        ("actual_q_5", "position", None), ("MOTOR1_ACT", "position", None),
        ("history", None, None), ("active", None, None), ("setup", None, None),
        ("i1_act", "effort", None), ("meas1", "position", None),
        ("ax1_meas_deg", "position", "deg"), ("act_1", "position", None),
        ("motor_fb_2", "position", None), ("temp_meas_1", "temp_c", None),
        ("i_act_1", "effort", None),
        ("ms", "t", "ms"), ("micros", "t", "us"), ("seconds", "t", "s"), ("s", None, None),
        ("min", None, None), ("current_position", "position", None),
        ("Current Angle (deg)", "position", "deg"), ("motor_current", "effort", None),
        ("vel_setpoint", None, None), ("torque_cmd", "effort", None),
        ("Following error", None, None), ("accel_x", None, None),
        ("/joint_states/position[2]", "position", None),
    ],
)  # fmt: skip
def test_names_in_several_trades_and_languages(name: str, role: str | None, unit: str) -> None:
    named = read_name(name)
    assert (named.role, named.unit) == (role, unit)


@pytest.mark.parametrize("seen", ["ax{}_act", "motor{}_fb", "angle_read_{}", "w{}"])
def test_readings_of_three_arms_are_found_beside_their_commands(tmp_path: Path, seen: str) -> None:
    """By their names, or as they move like them; once they were left out without a word."""
    angles = {f"ax{n}_cmd": 0.1 * n + ASKED * (1 + 0.2 * n) for n in (1, 2, 3)}
    read = {seen.format(n): angles[f"ax{n}_cmd"] + 2e-3 * NOISE[n - 1] for n in (1, 2, 3)}
    found = table(tmp_path, t=T_S, **angles, **read)
    assert found.kind == "delta"
    assert {name: taken(found)[name] for name in ("theta_1", "theta_2", "theta_3")} == {
        f"theta_{n}": seen.format(n) for n in (1, 2, 3)
    }


def test_a_reading_whose_name_says_nothing_has_the_unit_of_its_command(tmp_path: Path) -> None:
    found = table(tmp_path, time_s=T_S, target_deg=np.degrees(ASKED), blob=np.degrees(SEEN))
    assert taken(found) == {"t": "time_s", "command": "target_deg", "position": "blob"}
    assert found.guesses["blob"].unit == "deg"
    assert found.guesses["blob"].why == "moves like target_deg"


@pytest.mark.parametrize("first", [True, False])
def test_of_two_positions_the_earlier_was_commanded_and_somebody_is_asked(
    tmp_path: Path, first: bool
) -> None:
    columns = {"angle_a": ASKED, "angle_b": SEEN} if first else {"angle_a": SEEN, "angle_b": ASKED}
    found = table(tmp_path, t=T_S, **columns)
    asked, read = ("angle_a", "angle_b") if first else ("angle_b", "angle_a")
    assert taken(found) == {"t": "t", "command": asked, "position": read}
    (warning,) = [one for one in found.warnings if "exchange the two" in one]
    assert warning.startswith(f"{asked}: taken for the command")


def test_what_moves_alike_beside_an_effort_is_no_command(tmp_path: Path) -> None:
    """Two encoders of one axis, and the current that drives it."""
    found = table(tmp_path, t=T_S, angle=SEEN, load_side=SEEN + 1e-3 * NOISE[1], current=NOISE[2])
    assert "command" not in taken(found)


@pytest.mark.parametrize("rows", [30, 35, 80])
def test_a_short_table_without_known_names_is_looked_at(tmp_path: Path, rows: int) -> None:
    """A shift by more rows than there are ended in a traceback."""
    true = np.linspace(30.0, 300.0, rows)
    found = table(tmp_path, nr=np.arange(rows) + 1.0, foo=true, bar=1.02 * true + NOISE[0, :rows])
    assert {"foo", "bar"} <= set(found.guesses)


def test_a_calibration_table_beside_a_ruler(tmp_path: Path) -> None:
    true = np.linspace(30.0, 300.0, 35)
    found = table(tmp_path, nr=np.arange(35.0), surveyed_mm=true, vl53l0x=true + NOISE[0, :35])
    assert found.kind == "range_sensor"
    assert taken(found) == {"distance": "surveyed_mm", "range": "vl53l0x"}
    assert found.unused("nr") == "it counts the rows; a distance sensor needs no times"
    assert not [one for one in found.warnings if "rate_hz" in one]
    assert found.guesses["vl53l0x"].unit == "mm"


def test_a_pause_now_and_then_is_no_uneven_clock(tmp_path: Path) -> None:
    pauses = np.cumsum(np.where(np.arange(ROWS) % 150 == 149, 0.03, 0.0))
    found = table(tmp_path, t=T_S + pauses, command=ASKED, position=SEEN)
    assert not [one for one in found.warnings if "uneven" in one]
    jitter = np.sort(T_S + 0.004 * NOISE[1])
    found = table(tmp_path, t=jitter, command=ASKED, position=SEEN)
    (warning,) = [one for one in found.warnings if "uneven" in one]
    rate_hz = float(warning.partition("--set rate_hz=")[2].split()[0])
    assert abs(rate_hz - 1 / (T_S[1] - T_S[0])) < 0.5


def test_of_several_joints_the_first_that_moves_is_taken(tmp_path: Path) -> None:
    """One that stands still tells nothing, and the printed command was refused for it."""
    still = np.zeros(ROWS)
    found = table(tmp_path, t=T_S, q1_ref=still, q2_ref=ASKED, q1=still + 1e-3 * NOISE[0], q2=SEEN)
    assert taken(found) == {"t": "t", "command": "q2_ref", "position": "q2"}
