"""An arm of which commands and angles are known, and no efforts: what each joint does with both."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from deltactl.diagnosis.api import diagnose
from tests.diagnosis.test_chain_of_joints import efforts

pytest.importorskip("mujoco")

STIFF = 800.0
"""Of the shoulder [N m/rad]."""
HOME_RAD, PLAY_RAD, LATE_S = 0.03, 0.02, 0.06


def _followed(folder: Path) -> Path:
    """The waist has its home elsewhere, the shoulder yields, the elbow has play, all are late."""
    rng = np.random.default_rng(3)
    t_s = np.arange(0.0, 40.0, 0.02)
    waves = 2.0 * np.pi * np.array([[0.11, 0.23], [0.13, 0.19], [0.17, 0.29]])
    sizes = np.array([[0.8, 0.3], [0.6, 0.4], [0.7, 0.3]])

    pairs = list(zip(waves, sizes, strict=True))

    def asked(at_s: np.ndarray) -> np.ndarray:
        return np.stack([(np.sin(np.outer(at_s, w)) @ s) for w, s in pairs], axis=1)

    at = asked(t_s - LATE_S)
    at[:, 0] += HOME_RAD
    at[:, 1] -= efforts(at, 0.0 * at, 0.0 * at, 0.0)[:, 1] / STIFF
    held = at[0, 2]
    for row, angle in enumerate(at[:, 2]):
        held = np.clip(held, angle - 0.5 * PLAY_RAD, angle + 0.5 * PLAY_RAD)
        at[row, 2] = held
    at += 2e-4 * rng.standard_normal(at.shape)
    names = [f"{stem}_{n}" for stem in ("command", "theta") for n in (1, 2, 3)]
    table = folder / "followed.csv"
    rows = np.column_stack([t_s, asked(t_s), at])
    np.savetxt(table, rows, "%.8g", ",", header=",".join(["t", *names]), comments="")
    return table


@pytest.mark.study
def test_joints_that_follow_commands_are_found_late_displaced_loose_and_compliant(
    robot: Path,
) -> None:
    answer = diagnose([_followed(robot.parent)], robot)
    found = {(one.effect, one.component): one for one in answer.findings}
    for joint in ("waist", "shoulder", "elbow"):
        total = found["following_lag", joint].parameters["total"].value
        assert total == pytest.approx(LATE_S, abs=0.003)
    home = found["home_offset", "waist"].parameters["angle"].value
    assert home == pytest.approx(HOME_RAD, abs=1e-3)
    stiffness = found["joint_compliance", "shoulder"].parameters["stiffness"].value
    assert stiffness == pytest.approx(STIFF, rel=0.05)
    named = [found.get((name, "elbow")) for name in ("gear_backlash", "joint_friction")]
    widths = [one.parameters["width"].value for one in named if one is not None]
    assert widths == [pytest.approx(PLAY_RAD, rel=0.1)]
