"""Columns that are no motion: what adds up, what is on or off, and a way that only grows."""

from __future__ import annotations

from datetime import datetime, timedelta
from pathlib import Path

import numpy as np

from deltactl.recording.foreign.inspection import inspect
from deltactl.recording.foreign.mapping import load_mapping
from deltactl.recording.foreign.reading import read_mapped

T_S = 0.02 * np.arange(2000)
PLACE = 60.0 + 20.0 * np.sin(0.9 * T_S) + 8.0 * np.sin(2.3 * T_S)


def taken(path: Path, *columns: np.ndarray, head: str) -> dict[str, str]:
    np.savetxt(path, np.stack(columns, axis=1), "%.5f", ",", header=head, comments="")
    return {guess.name: column for column, guess in inspect(path).guesses.items()}


def test_what_adds_up_is_neither_command_nor_reading(tmp_path: Path) -> None:
    """Charge and a way in all grow together, and one is smoother than the other."""
    current = np.sign(np.gradient(PLACE)) + 0.2 * np.gradient(np.gradient(PLACE, T_S), T_S)
    charge = np.cumsum(np.abs(current)) * 1e-5
    way = np.floor(np.cumsum(np.abs(np.gradient(PLACE))))
    head = "ms_today,current_motor,amp_hours_used,tachometer_abs,encoder_position"
    found = taken(tmp_path / "vesc.csv", 2e4 * T_S, current, charge, way, PLACE, head=head)
    assert (found["position"], found["effort"]) == ("encoder_position", "current_motor")
    assert "command" not in found


def test_what_is_on_or_off_is_no_effort(tmp_path: Path) -> None:
    moving = (np.abs(np.gradient(PLACE)) > 0.1) * 1.0
    seen = np.interp(T_S - 0.05, T_S, PLACE)
    found = taken(tmp_path / "a.csv", T_S, seen, PLACE, moving, head="time,probe,plunger,moving")
    assert "effort" not in found
    assert {found["command"], found["position"]} == {"plunger", "probe"}


def test_a_way_that_only_grows_is_no_time(tmp_path: Path) -> None:
    true_cm = np.arange(8.0, 180.0, 4.0)
    read_cm = true_cm + 1.4 + 0.1 * np.random.default_rng(3).standard_normal(len(true_cm))
    head = "Real Distance (cm),HC-SR04 (cm)"
    found = taken(tmp_path / "ruler.csv", true_cm, read_cm, head=head)
    assert found == {"distance": "Real Distance (cm)", "range": "HC-SR04 (cm)"}


def test_of_dates_nobody_is_asked_whether_they_are_in_ms(tmp_path: Path) -> None:
    path = tmp_path / "table.csv"
    begin = datetime(2025, 3, 4, 10)
    rows = [
        f"{(begin + timedelta(seconds=4 * n)).isoformat()},{place:.3f},{place + 0.1:.3f}"
        for n, place in enumerate(PLACE[::5])
    ]
    path.write_text("\n".join(["timestamp,target_deg,actual_deg", *rows]) + "\n")
    told: list[str] = []
    options = inspect(path).options[1::2]
    read = read_mapped(path, load_mapping(None, options), told.append)
    np.testing.assert_allclose(np.diff(read.t_s), 4.0)
    assert told == []
