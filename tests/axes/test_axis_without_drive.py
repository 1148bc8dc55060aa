"""A stepper's axis whose rows are angles needs no `drive` section; rows of steps ask for one."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from deltactl.cli.main import app

ROBOT = "kind: stepper_axis\nname: angles\n"


def _table(folder: Path, command: str) -> tuple[Path, Path]:
    robot, rows = folder / "robot.yaml", folder / "run.csv"
    robot.write_text(ROBOT, encoding="utf-8")
    t_s = 0.05 * np.arange(400)
    rad = np.sin(0.7 * t_s)
    given = np.round(1000.0 * rad) if command == "steps_1" else rad
    seen = rad + 0.02 + 1e-4 * np.random.default_rng(1).standard_normal(len(t_s))
    lines = [f"t,{command},theta_1"]
    lines += [f"{t:.3f},{c:.10g},{s:.6f}" for t, c, s in zip(t_s, given, seen, strict=True)]
    rows.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return robot, rows


@pytest.mark.study
def test_angles_alone_are_diagnosed(tmp_path: Path) -> None:
    robot, rows = _table(tmp_path, "command_1")
    out = tmp_path / "answer.json"
    done = CliRunner().invoke(
        app,
        ["diagnose", str(rows), "--robot", str(robot), "--json", str(out),
         "--next-job", str(tmp_path / "next.yaml")],
    )  # fmt: skip
    assert done.exit_code == 0, done.output
    assert "job: none, as only deltas and chains have jobs" in done.output
    found = json.loads(out.read_text())["findings"]
    assert [one["effect"] for one in found] == ["home_offset"]
    assert found[0]["parameters"]["angle"]["value"] == pytest.approx(0.02, abs=1e-3)


def test_steps_ask_for_the_drive_in_one_line(tmp_path: Path) -> None:
    robot, rows = _table(tmp_path, "steps_1")
    done = CliRunner().invoke(app, ["diagnose", str(rows), "--robot", str(robot)])
    assert done.exit_code != 0
    said = str(done.exception)
    assert "steps_1 needs a `drive` section in the robot file" in said
