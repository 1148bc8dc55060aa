"""Two of the practice recordings through the whole command; skipped where they are not at hand."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from deltactl.diagnosis.api import diagnose

FOLDER = (
    Path(
        os.environ.get("DELTACTL_RECORDINGS")
        or Path(__file__).resolve().parents[2] / "../shared/recordings"
    )
    / "practice"
)

pytestmark = pytest.mark.skipif(
    not (FOLDER / "robot.yaml").exists(),
    reason="practice recordings not found; set DELTACTL_RECORDINGS to their folder",
)


@pytest.mark.study
def test_a_practice_recording_end_to_end(tmp_path: Path) -> None:
    case = FOLDER / "case_019"
    out = tmp_path / "answer.json"
    diagnose([case / "recording.csv.gz"], FOLDER / "robot.yaml", [case / "holdout.csv.gz"], out)
    answer = json.loads(out.read_text())
    assert [(f["effect"], f["component"]) for f in answer["findings"]] == [("gear_ratio", "motor2")]
    low, high = answer["findings"][0]["parameters"]["scale"]["ci95"]
    assert low < 1.0182 < high
    assert answer["fit"]["holdout_rms_after_m"] < 1.05 * answer["fit"]["noise_floor_m"]


@pytest.mark.study
def test_a_silent_practice_recording() -> None:
    answer = diagnose([FOLDER / "case_008" / "recording.csv.gz"], FOLDER / "robot.yaml")
    assert answer.verdict == "nothing_missing"
    assert not answer.findings
