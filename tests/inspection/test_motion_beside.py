"""The unit of an effort says whether an axis turns or slides, where its own motion has none."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from deltactl.foundation.one_screen import LINES
from deltactl.recording.foreign.inspection import inspect
from tests.inspection.test_shown import in_a_window

T_S = 0.005 * np.arange(3000)
PLACE = np.sin(0.9 * T_S) + 0.3 * np.sin(5.1 * T_S)
EFFORT = 0.1 * np.sign(np.gradient(PLACE)) + 0.02 * np.gradient(np.gradient(PLACE, T_S), T_S)


def write(path: Path, place: str, effort: str, *others: str) -> Path:
    turned = [30.0 + 0.001 * T_S for _ in others]
    columns = np.stack([T_S, PLACE, EFFORT, *turned], axis=1)
    head = ",".join(["Time (s)", place, effort, *others])
    np.savetxt(path, columns, "%.6f", ",", header=head, comments="", encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("place", "effort", "motion"),
    [
        ("pos_estimate", "torque_estimate (Nm)", "rotary"),
        ("pos", "motor_force [N]", "linear"),
        ("pos", "current [A]", None),
        ("pos_mm", "torque [Nm]", "linear"),
    ],
)
def test_a_torque_turns_and_a_force_slides(
    tmp_path: Path, place: str, effort: str, motion: str | None
) -> None:
    seen = inspect(write(tmp_path / "a.csv", place, effort))
    assert seen.kind == "servo_axis"
    assert seen.motion == motion
    assert (seen.asked is not None and seen.asked.motion) == (motion is None)


def test_remarks_on_columns_that_are_not_read_give_way_on_a_full_screen(tmp_path: Path) -> None:
    speed = "vel_estimate (counts/s)"
    path = write(tmp_path / "odrive.csv", "pos_estimate", "torque_estimate (Nm)", speed)
    table = np.genfromtxt(path, delimiter=",", skip_header=1)
    table[:, 3] = 8192.0 * np.gradient(table[:, 1], T_S)
    more = np.stack([30.0 + 0.1 * T_S, 31.0 + 0.2 * T_S], axis=1)
    head = f"Time (s),pos_estimate,torque_estimate (Nm),{speed},driver_temp (°C),motor_temp (°C)"
    table = np.concatenate([table, more], axis=1)
    np.savetxt(path, table, "%.6f", ",", header=head, comments="", encoding="utf-8")
    assert any(speed in one for one in inspect(path).warnings)
    shown = in_a_window(tmp_path, 80, "inspect", path.name)
    assert len(shown.rstrip("\n").splitlines()) <= LINES
    assert "deltactl diagnose" in shown


def test_joints_of_a_cnc_machine_turn_or_slide_in_its_own_unit(tmp_path: Path) -> None:
    path = tmp_path / "halscope.log"
    place = 6.0 + 5.0 * np.sin(0.3 * T_S)
    table = np.stack([T_S, place, np.interp(T_S - 0.01, T_S, place)], axis=1)
    head = "# time joint.0.motor-pos-cmd joint.0.motor-pos-fb"
    np.savetxt(path, table, "%.6f", " ", header=head, comments="")
    asked = inspect(path).asked
    assert asked is not None
    assert asked.motion
    assert "inch" in asked.linear
