"""`deltactl diagnose` says where its search ended early, and goes on when it is told to."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from deltactl.cli.main import main
from deltactl.diagnosis.estimation import budget
from deltactl.diagnosis.estimation.options import ESTIMATION
from deltactl.models.chain import Chain, Commands
from deltactl.models.robot import EffectEntry
from deltactl.models.robot_files import load_delta
from deltactl.recording.tables.flat import FlatRecording
from deltactl.recording.tables.flat_files import write_flat

ROBOT = Path(__file__).parents[2] / "config" / "zhao-2023.yaml"
SAMPLES = 750
WRONG = (
    EffectEntry(effect="sensor_scale", component="range_x", parameters={"scale": 1.03}),
    EffectEntry(effect="gear_ratio", component="motor2", parameters={"scale": 1.02}),
    EffectEntry(effect="sensor_offset", component="range_z", parameters={"offset": 0.02}),
)


@pytest.fixture(scope="module")
def wrong(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A quarter of a minute of a robot with three faults, as a file."""
    rng, t_s = np.random.default_rng(3), 0.02 * np.arange(SAMPLES)
    rad = 0.6 + 0.35 * np.sin(t_s[:, None] * np.array([0.9, 1.3, 2.1]))
    commands = Commands.of_angles(t_s, rad, np.arange(SAMPLES) == 0)
    seen = Chain.delta(load_delta(ROBOT)).simulate(commands, WRONG).ranges
    seen = np.round(seen + 0.002 * rng.standard_normal(seen.shape), 3)
    columns = {f"command_{j + 1}": rad[:, j] for j in range(3)}
    columns |= {f"range_{a}": seen[:, i] for i, a in enumerate("xyz")}
    path = tmp_path_factory.mktemp("thorough") / "wrong.csv.gz"
    write_flat(FlatRecording(t_s, columns, {}, "wrong"), path)
    return path


@pytest.mark.study
@pytest.mark.parametrize("thorough", [False, True])
def test_a_search_that_ends_early_says_so_and_thorough_goes_on(
    wrong: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    thorough: bool,
) -> None:
    monkeypatch.setattr(budget, "ESTIMATION", replace(ESTIMATION, predictions=5.0))
    options = ["--robot", str(ROBOT), "--json", "-", *(["--thorough"] if thorough else [])]
    monkeypatch.setattr("sys.argv", ["deltactl", "diagnose", str(wrong), *options])
    with pytest.raises(SystemExit) as caught:
        main()
    answer = json.loads(capsys.readouterr().out)
    assert caught.value.code in (0, None)
    assert answer["ended_early"] is not thorough
    assert any("--thorough" in line for line in answer["says"]) is not thorough
    found = {(one["effect"], one["component"]) for one in answer["findings"]}
    assert (found == {(one.effect, one.component) for one in WRONG}) is thorough
