"""Answers to drawn recordings, and to real ones, agree with themselves."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from benchmarks.proofs.contradictions import contradictions
from deltactl.diagnosis.answer.corrected_robot import save_corrected
from deltactl.diagnosis.api import diagnose, diagnose_recordings
from deltactl.models.robot import DeltaRobot, EffectEntry
from tests.diagnosis.conftest import Record

pytestmark = pytest.mark.study

REAL = Path(
    os.environ.get("DELTACTL_RECORDINGS", Path(__file__).parents[2] / "../shared/recordings")
)
FEW = None if "DELTACTL_RECORDINGS" in os.environ else 3
"""All where their folder is named; benchmarks/proofs/frozen_answers.py checks the same."""
MACHINES = sorted(
    (file.parent for file in REAL.glob("*/expected.json")),
    key=lambda machine: (min(file.stat().st_size for file in machine.iterdir()), machine.name),
)[:FEW]


def entry(effect: str, component: str, **parameters: float) -> EffectEntry:
    return EffectEntry(effect=effect, component=component, parameters=parameters)


EFFECTS = st.sampled_from(
    [
        entry("home_offset", "motor1", angle=0.01),
        entry("gear_backlash", "motor2", width=0.01, drag=10.0),
        entry("following_lag", "motor3", time=0.0, dead_time=0.06),
        entry("lost_steps", "motor1", steps=0.6, time=12.0),
        entry("lost_steps", "motor2", steps=40.0, time=14.0),
        entry("sensor_scale", "range_z", scale=1.02),
    ]
)


@pytest.mark.timeout(900)
@settings(
    max_examples=3, deadline=None, derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)  # fmt: skip
@given(
    effects=st.lists(EFFECTS, max_size=2, unique_by=lambda one: (one.effect, one.component)),
    sway_m=st.sampled_from([0.0, 0.0, 0.004]),
    seed=st.integers(1, 1000),
)
def test_answers_to_drawn_recordings_agree_with_themselves(
    delta: DeltaRobot, record: Record, effects: list[EffectEntry], sway_m: float, seed: int
) -> None:
    recording = record(*effects, seed=seed, seconds=30.0)
    recording.columns["range_y"] += sway_m * np.sin(2.0 * np.pi * 0.37 * recording.t_s)
    answer = diagnose_recordings(delta, [recording])
    assert contradictions(answer) == []
    assert all(finding.says for finding in answer.findings)
    assert "NaN" not in json.dumps(answer.to_json())


@pytest.mark.timeout(900)
@pytest.mark.skipif(not MACHINES, reason="the shared recordings are not here (DELTACTL_RECORDINGS)")
@pytest.mark.parametrize("folder", MACHINES, ids=lambda folder: folder.name)
def test_answers_to_real_recordings_agree_with_themselves(folder: Path, tmp_path: Path) -> None:
    """The shortest recording of each machine that is not refused, and that once more against the
    robot file with everything that was found.
    """
    names = [name for name in json.loads((folder / "expected.json").read_text()) if name[0] != "_"]
    files = sorted((folder / name for name in names), key=lambda file: file.stat().st_size)
    for file in files:
        try:
            answer = diagnose([file], folder / "robot.yaml")
        except ValueError:
            continue
        assert contradictions(answer) == []
        if answer.findings:
            new = tmp_path / "new.yaml"
            save_corrected(folder / "robot.yaml", answer, new, all_of_them=True)
            assert contradictions(diagnose([file], new)) == []
        return
    pytest.skip("all its recordings are refused")
