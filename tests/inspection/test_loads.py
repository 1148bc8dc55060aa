"""Which torque beside a command is the drive's own, and which pulls from outside."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from deltactl.recording.foreign.inspection import inspect
from deltactl.recording.foreign.mapping import load_mapping

PERIOD_S, REST_ROWS, MOVE_ROWS = 0.1, 40, 10


def motion() -> np.ndarray:
    """To and fro between two places, in counts, (n,)."""
    move = np.linspace(0.0, 400.0, MOVE_ROWS)
    once = [np.zeros(REST_ROWS), move, np.full(REST_ROWS, 400.0), move[::-1]]
    return np.tile(np.concatenate(once), 4)


def log(path: Path, torque: np.ndarray, place: np.ndarray) -> Path:
    rows = np.stack([PERIOD_S * np.arange(len(place)), np.roll(place, -1), place, torque], axis=1)
    head = "t,Goal_Position,Present_Position,torque_Nm"
    np.savetxt(path, rows, "%.4f", ",", header=head, comments="")
    return path


@pytest.mark.parametrize(
    ("in_motion", "role", "other"), [(0.0, "load", "effort"), (0.3, "effort", "load")]
)
def test_a_torque_that_is_none_while_the_axis_moves_is_a_load(
    tmp_path: Path, in_motion: float, role: str, other: str
) -> None:
    """A drive that moves an axis has friction and inertia to overcome."""
    place = motion()
    speed = np.gradient(place)
    at_rest = np.where(np.arange(len(place)) % 50 > 20, 0.25, 0.0) * (np.abs(speed) < 1e-9)
    path = log(tmp_path / "log.csv", at_rest + in_motion * np.sign(speed), place)
    found = inspect(path)
    assert found.guesses["torque_Nm"].role == role
    assert f"{role}=torque_Nm" in found.options
    (warning,) = [one for one in found.warnings if one.startswith("torque_Nm: taken for")]
    assert f"put {other} in place of {role} in the printed command" in warning
    assert ("effort" in found.kind_why) == (role == "effort")


T_S = 0.05 * np.arange(400)
ASKED = np.sin(T_S)


@pytest.mark.parametrize(
    ("heading", "u", "read"),
    [
        ("time,u,y", ASKED, "command=u"),
        ("time,u_rad,q_rad", 1.3 * ASKED, "command=u_rad[rad]"),
        ("time,u,pos_deg", ASKED, "command=u[deg]"),
        ("time,u,y", 2.0 * ASKED, None),
        ("time,u,y", np.cos(T_S), None),
        ("time,torque_Nm,y", ASKED, None),
    ],
)
def test_what_is_called_an_effort_and_moves_as_the_axis_may_be_its_command(
    tmp_path: Path, heading: str, u: np.ndarray, read: str | None
) -> None:
    """A log calls u what it asked for; it was an effort without a word."""
    rows = np.stack([T_S, u, np.roll(ASKED, 3)], axis=1)
    path = tmp_path / "log.csv"
    np.savetxt(path, rows, "%.5f", ",", header=heading, comments="")
    found = inspect(path)
    said = [one for one in found.warnings if "may be its command" in one]
    assert bool(said) == (read is not None)
    if read is not None:
        assert f"--set {read}" in said[0].replace("'", "")
        other = inspect(path, load_mapping(None, [read]))
        assert {"command", "position"} <= {one.name for one in other.guesses.values()}
        assert not any("may be its command" in one for one in other.warnings)
