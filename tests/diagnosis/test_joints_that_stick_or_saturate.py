"""Joints of an arm that stick near standstill, and drives that reach their limit.

The arm is that of `test_chain_of_joints`, which shares no code with the models. A drive at its
limit no longer follows: the motion of its joint is integrated, with the effort that it gives.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from deltactl.diagnosis.api import diagnose
from tests.diagnosis.test_chain_of_joints import FRICTION_NM, efforts, recorded

pytest.importorskip("mujoco")

STICKS_NM, WITHIN_RADPS = 1.2, 0.3
LIMIT_NM, UNREACHED_NM = 16.0, 100.0
STEP_S, SECONDS = 0.004, 25.0
EVERY = 3
"""Steps from one sample to the next."""
SHOULDER = 1


def _sticks(t_s: np.ndarray, q: np.ndarray, dq: np.ndarray, effort: np.ndarray) -> np.ndarray:
    speed = dq[:, SHOULDER]
    rubs = FRICTION_NM + STICKS_NM * np.exp(-((speed / WITHIN_RADPS) ** 2))
    made = effort.copy()
    made[:, SHOULDER] += rubs * np.sign(speed)
    return made


def _saturated(folder: Path, limit_nm: float) -> Path:
    """A table of a motion that the drive of the shoulder follows as far as it can."""
    rng = np.random.default_rng(3)
    t_s = np.arange(0.0, SECONDS, STEP_S)
    planned = np.zeros((3, len(t_s), 3))
    for j in range(3):
        for w in 2.0 * np.pi * 0.12 * np.arange(1, 5):
            size, phase = 0.6 / w * rng.uniform(0.5, 1.0), rng.uniform(0.0, 2.0 * np.pi)
            for order in range(3):
                turned = w * t_s + phase + 0.5 * np.pi * order
                planned[order, :, j] += size * w**order * np.sin(turned)
    q, dq, ddq = planned.copy()
    asked = efforts(*planned, 0.0)[:, SHOULDER]
    for row in range(len(t_s) - 1):
        behind = planned[:2, row, SHOULDER] - (q[row, SHOULDER], dq[row, SHOULDER])
        asked[row] += behind @ (60.0, 12.0)
        two = np.repeat(ddq[None, row], 2, axis=0)
        two[:, SHOULDER] = (0.0, 1.0)
        rest, moved = efforts(q[[row, row]], dq[[row, row]], two, 0.0)[:, SHOULDER]
        given = float(np.clip(asked[row], -limit_nm, limit_nm))
        ddq[row, SHOULDER] = rise = (given - rest) / (moved - rest)
        speed = dq[row, SHOULDER]
        q[row + 1, SHOULDER] = q[row, SHOULDER] + STEP_S * (speed + 0.5 * STEP_S * rise)
        dq[row + 1, SHOULDER] = speed + STEP_S * rise
    effort = efforts(q, dq, ddq, 0.0)
    effort[:, SHOULDER] = asked
    rows = slice(0, len(t_s) - EVERY, EVERY)
    noisy = [2e-5, 0.05] * rng.standard_normal((*q[rows].shape, 2))
    table = np.column_stack([t_s[rows], q[rows] + noisy[..., 0], effort[rows] + noisy[..., 1]])
    head = ",".join(["t", *(f"{name}_{n}" for name in ("theta", "effort") for n in (1, 2, 3))])
    np.savetxt(folder / "run.csv", table, "%.8g", ",", header=head, comments="")
    return folder / "run.csv"


def _stated(robot: Path, effect: str, **parameters: float) -> None:
    entry: dict[str, Any] = {"effect": effect, "component": "shoulder", "parameters": parameters}
    text = robot.read_text().replace("effects: [", f"effects: [{entry}, ")
    robot.write_text(text if "effects: [" in text else f"{text}effects: [{entry}]\n")


@pytest.mark.study
def test_friction_that_falls_with_speed_is_found_with_its_sizes(robot: Path) -> None:
    table = recorded(robot.parent, fault=_sticks, seconds=60.0)
    found = {(one.effect, one.component): one for one in diagnose([table], robot).findings}
    assert set(found) == {("joint_friction", "shoulder"), ("stribeck_friction", "shoulder")}
    sizes = found["stribeck_friction", "shoulder"].parameters
    for name, truth in (("torque", STICKS_NM), ("speed", WITHIN_RADPS)):
        value, low, high = sizes[name].components[0]
        assert low <= truth <= high
        assert value == pytest.approx(truth, rel=0.1)
    assert "degrees/s" in found["stribeck_friction", "shoulder"].says
    _stated(robot, "joint_friction", torque=FRICTION_NM)
    _stated(robot, "stribeck_friction", torque=STICKS_NM, speed=WITHIN_RADPS)
    assert diagnose([table], robot).findings == []


@pytest.mark.study
def test_a_drive_that_reaches_its_limit_is_found_with_its_limit(robot: Path) -> None:
    table = _saturated(robot.parent, LIMIT_NM)
    (found,) = diagnose([table], robot).findings
    assert (found.effect, found.component) == ("effort_limit", "shoulder")
    value, low, high = found.parameters["limit"].components[0]
    assert low <= LIMIT_NM <= high
    assert value == pytest.approx(LIMIT_NM, rel=0.1)
    _stated(robot, "effort_limit", limit=LIMIT_NM)
    assert diagnose([table], robot).findings == []


@pytest.mark.study
def test_a_drive_that_does_not_reach_its_limit_has_none(robot: Path) -> None:
    assert diagnose([_saturated(robot.parent, UNREACHED_NM)], robot).findings == []
