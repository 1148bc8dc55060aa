"""Figures and pictures of a delta with several kinds of channels: each in its own unit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from deltactl.diagnosis.answer.records import Diagnosis
from deltactl.diagnosis.api import diagnose_recordings
from deltactl.models.chain import Chain, Commands
from deltactl.models.robot import EffectEntry
from deltactl.models.robot_files import load_delta
from deltactl.recording.tables.flat import FlatRecording

RANGES_M, ANGLES_RAD = 1e-3, 2e-4
"""Noise of the readings."""
STUCK = slice(1000, 1150)


@pytest.fixture(scope="module")
def answer() -> Diagnosis:
    """Of a delta with too wide a base, its arms' angles measured, and one sensor stuck for 3 s."""
    delta = load_delta(Path(__file__).parents[2] / "config" / "zhao-2023.yaml")
    rng = np.random.default_rng(4)
    t_s = 0.02 * np.arange(2000)
    turn = np.outer(t_s, (0.9, 1.3, 1.7)) + np.arange(3.0)
    rad = 0.5 + 0.3 * np.sin(turn)
    wide = EffectEntry(effect="base_radius", component="frame", parameters={"length_error": 0.01})
    commands = Commands.of_angles(t_s, rad, np.arange(len(t_s)) == 0)
    seen = Chain(delta).simulate(commands, [wide])
    ranges = np.round(seen.ranges + RANGES_M * rng.standard_normal(rad.shape), 4)
    ranges[STUCK, 1] = ranges[STUCK.start, 1]
    angles = rad + ANGLES_RAD * rng.standard_normal(rad.shape)
    columns = {f"command_{j + 1}": rad[:, j] for j in range(3)}
    columns |= {f"theta_{j + 1}": angles[:, j] for j in range(3)}
    columns |= {f"range_{a}": ranges[:, i] for i, a in enumerate("xyz")}
    return diagnose_recordings(delta, [FlatRecording(t_s, columns, {}, "drawn")])


def test_figures_are_of_the_channels_in_metres(answer: Diagnosis) -> None:
    assert answer.fit.unit == "m"
    assert answer.fit.rms_before_m > 3.0 * RANGES_M
    assert answer.fit.rms_after_m == pytest.approx(RANGES_M, rel=0.1)
    assert answer.fit.noise_floor_m == pytest.approx(RANGES_M, rel=0.1)


def test_each_channel_is_drawn_in_its_unit_with_its_noise(answer: Diagnosis) -> None:
    assert answer.picture is not None
    units = {one.name: one.unit for one in answer.picture.channels}
    assert {units[f"range_{a}"] for a in "xyz"} == {"m"}
    assert {units[f"theta_{j}"] for j in (1, 2, 3)} == {"rad"}
    for one in answer.picture.channels:
        noise = RANGES_M if one.unit == "m" else ANGLES_RAD
        assert one.noise == pytest.approx(noise, rel=0.15)
        assert len(one.observed) == len(answer.picture.t_s)


def test_what_a_sensor_repeated_is_drawn_as_it_was_read(answer: Diagnosis) -> None:
    assert ("stale_reading", "range_y") in {(f.effect, f.component) for f in answer.findings}
    assert answer.picture is not None
    (stuck,) = (one for one in answer.picture.channels if one.name == "range_y")
    held = slice(STUCK.start + 1, STUCK.stop)
    assert np.array_equal(stuck.after[held], stuck.observed[held])
    assert stuck.counted is not None
    assert not stuck.counted[held].any()
