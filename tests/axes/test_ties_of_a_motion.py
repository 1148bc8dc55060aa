"""Causes that a motion makes equal are one tie: all are named, and none is claimed alone."""

from __future__ import annotations

import numpy as np
import pytest

from deltactl.diagnosis.answer.records import Diagnosis
from deltactl.diagnosis.api import diagnose_recordings
from deltactl.models.robot import ServoAxis
from deltactl.recording.tables.flat import FlatRecording, from_columns

pytest.importorskip("scipy", reason="the diagnosis needs the extra 'diagnosis'")

FOLLOWS = ServoAxis(kind="servo_axis", name="follows", motion="rotary")
SLIDE = ServoAxis(kind="servo_axis", name="slide", motion="linear", inertia=2.0)
SURE = 0.9


def offered(answer: Diagnosis) -> dict[str, float]:
    """Every effect that is named or an alternative, with its largest probability."""
    found: dict[str, float] = {}
    for one in answer.findings:
        for other in (one, *one.alternatives):
            found[other.effect] = max(found.get(other.effect, 0.0), other.probability or 0.0)
    return found


def one_way(behind_rad: float, back: bool = False) -> FlatRecording:
    """An axis that goes up, with rests (and back again), and hangs on the same flank of a play."""
    t_s = np.arange(0.0, 60.0, 0.02)
    up = np.interp(t_s % 6.0, [0.0, 4.0, 6.0], [0.0, 1.0, 1.0]) + np.floor(t_s / 6.0)
    command = 0.1 * up
    if back:
        command = np.where(t_s < 30.0, command, 2.0 * command[1499] - command)
    noise = np.random.default_rng(5).normal(0.0, 1e-4, len(t_s))
    at, seen = command[0] - behind_rad, np.empty_like(t_s)
    for row, asked in enumerate(command):
        at = min(max(at, asked - behind_rad), asked + behind_rad)
        seen[row] = at + noise[row]
    return from_columns({"t": t_s, "command": command, "position": seen}, "one way")


@pytest.mark.study
def test_a_one_way_run_leaves_home_offset_and_play_or_friction_open() -> None:
    answer = diagnose_recordings(FOLLOWS, [one_way(2e-3)])
    chances = offered(answer)
    assert "home_offset" in chances
    assert {"gear_backlash", "joint_friction"} & chances.keys()
    assert max(chances.values()) < SURE


@pytest.mark.study
def test_the_way_back_settles_it() -> None:
    answer = diagnose_recordings(FOLLOWS, [one_way(2e-3, back=True)])
    assert answer.findings[0].effect in ("gear_backlash", "joint_friction")
    assert offered(answer).get("home_offset", 0.0) < 0.2


def pushed(offset_n: float, gain: float = 1.0, weight_n: float = 0.0) -> FlatRecording:
    """A slide by its effort, always onward, or to and fro under a known constant weight."""
    t_s = np.arange(0.0, 20.0, 0.01)
    onward = 0.4 if not weight_n else 0.0
    position = onward * t_s + 0.1 * np.sin(2.0 * t_s) + 0.03 * np.sin(3.7 * t_s + 1.0)
    accel = -0.4 * np.sin(2.0 * t_s) - 0.03 * 3.7**2 * np.sin(3.7 * t_s + 1.0)
    noise = np.random.default_rng(6).normal(0.0, 0.02, len(t_s))
    effort = (2.0 * accel - weight_n + offset_n) / gain + noise
    columns = {"t": t_s, "position": position, "effort": effort}
    if weight_n:
        columns["load"] = np.full_like(t_s, weight_n)
    return from_columns(columns, "pushed")


@pytest.mark.study
def test_onward_only_friction_is_no_more_than_a_constant_effort() -> None:
    answer = diagnose_recordings(SLIDE, [pushed(0.5)])
    chances = offered(answer)
    assert {"effort_offset", "joint_friction"} <= chances.keys()
    assert max(chances["effort_offset"], chances["joint_friction"]) < SURE


@pytest.mark.study
def test_a_known_constant_weight_tells_the_gain_from_mass_and_offset() -> None:
    answer = diagnose_recordings(SLIDE, [pushed(0.0, gain=1.15, weight_n=20.0)])
    assert [one.effect for one in answer.findings] == ["effort_gain"]
