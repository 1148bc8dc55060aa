"""`deltactl demo prove --heal`: a robot of the independent simulator draws better afterwards."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from deltactl.cli.main import app


@pytest.mark.study
def test_a_robot_that_shares_nothing_with_the_model_heals(tmp_path: Path) -> None:
    words = ("demo", "prove", "--heal", "--cases", "1", "--seed", "5", "--workers", "0", "--out")
    done = CliRunner().invoke(app, [*words, str(tmp_path)])
    assert done.exit_code == 0, done.output
    row = json.loads((tmp_path / "heal-5-0000.json").read_text())
    assert row["hidden"] == ["upper_arm_length"]
    assert row["outcome"] == "healed"
    assert row["after_m"] < 0.15e-3 < row["before_m"]
    assert "1 of 1" in done.output
