"""What an axis does between two rows, and rows that are stamped roughly, move no size."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import cumulative_simpson

from deltactl.diagnosis.answer.records import Finding
from deltactl.diagnosis.api import diagnose_recordings
from deltactl.diagnosis.observations.inverse_dynamics import motion_of
from deltactl.models.effects.flow import Flow, Load
from deltactl.models.effects.lone_axis import command_effects
from deltactl.models.robot import ServoAxis
from deltactl.recording.tables.flat import from_columns

AXIS = ServoAxis(kind="servo_axis", name="joint", motion="rotary")
STEP_S, LIMIT, NOISE_RAD = 0.0005, 1.1, 1e-4
FloatArray = NDArray[np.float64]


def held_back(asked: FloatArray) -> FloatArray:
    """A motion that goes no faster than the limit, step by step."""
    at, most, done = float(asked[0]), LIMIT * STEP_S, []
    for aim in asked.tolist():
        at += min(max(aim - at, -most), most)
        done.append(at)
    return np.array(done)


def limit_of(every: int, stamped_s: float) -> Finding:
    """What is found of a limit in rows so many steps apart, stamped so much off."""
    rng = np.random.default_rng(11)
    t_s = np.arange(0.0, 40.0, STEP_S)
    asked = 0.3 * np.sin(2.0 * np.pi * 0.6 * t_s) + 0.1 * np.sin(2.0 * np.pi * 0.25 * t_s)
    rows = np.arange(0, len(t_s), every)
    read = held_back(asked)[rows] + NOISE_RAD * rng.standard_normal(len(rows))
    stamps_s = t_s[rows] + stamped_s * rng.uniform(-1.0, 1.0, len(rows))
    columns = {"t": stamps_s, "command": asked[rows], "position": read}
    (finding,) = diagnose_recordings(AXIS, [from_columns(columns, "a.csv")]).findings
    return finding


@pytest.mark.parametrize(("every", "stamped_s"), [(80, 0.0), (40, 0.001)])
def test_a_limit_of_the_speed_is_reached_between_two_rows(every: int, stamped_s: float) -> None:
    finding = limit_of(every, stamped_s)
    assert finding.effect == "speed_limit"
    ((value, low, high),) = finding.parameters["limit"].components
    assert value == pytest.approx(LIMIT, rel=1e-3)
    assert low < LIMIT < high


@pytest.mark.parametrize("rows", [1, 7, 50])
def test_a_limit_of_the_speed_knows_the_motion_before_its_block(rows: int) -> None:
    """Rows as a running robot has them, some at a time, beside all at once."""
    t_s = np.arange(0.0, 8.0, 0.02)
    asked = cumulative_simpson(0.9 + 0.3 * np.sin(t_s), dx=0.02, initial=0.0)
    whole, parts = (in_blocks(t_s, asked, every) for every in (len(t_s), rows))
    assert np.abs(whole - asked).max() > 0.01
    assert np.abs(parts - whole).max() < 1e-3


def in_blocks(t_s: FloatArray, asked: FloatArray, rows: int) -> FloatArray:
    """What a limited axis does of a command that comes some rows at a time."""
    kind, memory = command_effects("rotary")["speed_limit"], dict[str, Any]()
    done = []
    for first in range(0, len(t_s), rows):
        part = slice(first, first + rows)
        flow = Flow(
            t_s=t_s[part],
            fresh=np.arange(len(t_s))[part] == 0,
            start_s=0.0,
            angles_rad=asked[part, None].copy(),
            load_of=lambda: Load(np.zeros((0, 1)), np.zeros((0, 1))),
            previous_s=t_s[first - 1] if first else None,
        )
        kind.operate(flow, 0, {"limit": np.array(LIMIT)}, memory)
        done.append(flow.angles_rad[:, 0])
    return np.concatenate(done)


def test_friction_follows_a_velocity_that_turns_as_fast_as_the_axis() -> None:
    t_s = np.arange(0.0, 30.0, 0.005)
    speed = np.tanh(12.0 * np.sin(2.0 * np.pi * 0.5 * t_s))
    way = cumulative_simpson(speed, dx=0.005, initial=0.0)
    read = way + 2e-5 * np.random.default_rng(2).standard_normal(len(t_s))
    motion = motion_of(t_s, np.arange(len(t_s)) == 0, read, None)
    turns = motion.settled & (np.abs(speed) < 0.5)
    off = [np.std((course - speed)[turns]) for course in (motion.turning, motion.velocity)]
    assert off[0] < 0.5 * off[1]


def test_an_unknown_takes_back_what_a_wave_of_the_gear_stood_in_for() -> None:
    """A drive that is later in one direction; named effects alone come nearest by waves."""
    rng = np.random.default_rng(5)
    t_s = np.arange(0.0, 20.0, 0.013)
    number, share = np.divmod(t_s, 0.5)
    ends = np.cumsum(np.concatenate([[0.0], rng.choice([-1.2, 1.2], 60)]))
    ends = ends - 2.0 * np.round(ends / 2.0)
    turn = np.clip(2.5 * share, 0.0, 1.0)
    bend = turn - np.sin(2.0 * np.pi * turn) / (2.0 * np.pi)
    begin, end = ends[number.astype(int)], ends[number.astype(int) + 1]
    speed = (end - begin) * 2.5 * (1.0 - np.cos(2.0 * np.pi * turn)) * (turn < 1.0)
    command = begin + (end - begin) * bend
    late_s = np.where(speed > 0.0, 0.004, 0.008)
    read = command - late_s * speed + 1e-3 * rng.standard_normal(len(t_s))
    columns = {"t": t_s, "command": command, "position": read}
    answer = diagnose_recordings(AXIS, [from_columns(columns, "a.csv")])
    found = {one.effect for one in answer.findings}
    assert {"following_lag", "unknown"} <= found
    assert "transmission_error" not in found
