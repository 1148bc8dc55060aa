"""A table of an axis beside the robot file of a delta: the kinds are what is said first."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.cli.conftest import Deltactl

T_S = 0.01 * np.arange(600)


@pytest.mark.parametrize(
    "names", ["t,target_angle,present_angle", "ms,goal,read", "t,command,position"]
)
def test_a_table_of_an_axis_and_a_robot_file_of_a_delta(
    deltactl: Deltactl, tmp_path: Path, names: str
) -> None:
    asked = 40.0 * np.sin(T_S)
    cells = np.stack([T_S, asked, 0.97 * asked], axis=1)
    np.savetxt(tmp_path / "axis.csv", cells, "%.5f", ",", header=names, comments="")
    done = deltactl("diagnose", "axis.csv", "--robot", "zhao-2023.yaml", status=2)
    said = " ".join(done.stderr.split())
    assert "looks like a table of a servo_axis" in said
    assert "the robot file describes a delta" in said
    assert "deltactl inspect" in said
