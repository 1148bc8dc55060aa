"""Concealed effects come out with their component and size; nothing is claimed where nothing is."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from deltactl.diagnosis.api import diagnose_recordings
from deltactl.models.robot import DeltaRobot, EffectEntry
from deltactl.recording.tables.flat import FlatRecording

pytestmark = pytest.mark.study

Record = Callable[..., FlatRecording]


def _entry(effect: str, component: str, **parameters: float) -> EffectEntry:
    return EffectEntry(effect=effect, component=component, parameters=dict(parameters))


@pytest.mark.parametrize("seed", [1, 2])
def test_nothing_hidden_nothing_claimed(delta: DeltaRobot, record: Record, seed: int) -> None:
    answer = diagnose_recordings(delta, [record(seed=seed)])
    assert answer.verdict == "nothing_missing"
    assert answer.findings == []
    assert answer.false_alarm_p > 0.005


CASES = [
    (_entry("home_offset", "motor2", angle=0.013), "angle"),
    (_entry("sensor_scale", "range_z", scale=1.015), "scale"),
    (_entry("transmission_error", "motor1", amplitude=0.006, period=2 * np.pi / 10), "amplitude"),
    (_entry("following_lag", "motor3", time=0.1), "time"),
    (_entry("gear_backlash", "motor1", width=0.012), "width"),
    (_entry("joint_friction", "motor2", width=0.009, stiffness=2000.0), "width"),
    (_entry("lost_steps", "motor3", steps=64.0, time=16.0), "steps"),
]


@pytest.mark.parametrize(("entry", "parameter"), CASES, ids=[e.effect for e, _ in CASES])
def test_a_hidden_effect_is_named_with_its_size(
    delta: DeltaRobot, record: Record, entry: EffectEntry, parameter: str
) -> None:
    answer = diagnose_recordings(delta, [record(entry)])
    assert [(f.effect, f.component) for f in answer.findings] == [(entry.effect, entry.component)]
    size = answer.findings[0].parameters[parameter]
    truth = entry.parameters[parameter]
    assert isinstance(truth, float)
    low, high = np.ravel(size.ci95)
    spread = (high - low) / 3.92
    assert low - 1.5 * spread <= truth <= high + 1.5 * spread
    assert answer.fit.holdout_rms_after_m < answer.fit.holdout_rms_before_m
    assert answer.fit.holdout_rms_after_m < 1.15 * answer.fit.noise_floor_m


def test_a_small_effect_is_seen_beside_a_large_one(delta: DeltaRobot, record: Record) -> None:
    """Geometry leaves no blur: what it does not explain is somebody else's doing."""
    answer = diagnose_recordings(
        delta,
        [
            record(
                _entry("base_radius", "frame", length_error=-0.012),
                _entry("joint_friction", "motor2", width=0.005, stiffness=2000.0),
            )
        ],
    )
    assert {(f.effect, f.component) for f in answer.findings} == {
        ("base_radius", "frame"),
        ("joint_friction", "motor2"),
    }


def test_the_moment_of_a_loss_is_found(delta: DeltaRobot, record: Record) -> None:
    answer = diagnose_recordings(
        delta, [record(_entry("lost_steps", "motor2", steps=64.0, time=22.0))]
    )
    time = answer.findings[0].parameters["time"]
    assert time.value == pytest.approx(22.0, abs=0.3)


def test_a_loss_happened_before_late_readings_show_it(delta: DeltaRobot, record: Record) -> None:
    late = _entry("sensor_latency", "sensors", time=0.15)
    loss = _entry("lost_steps", "motor2", steps=100.0, time=22.0)
    answer = diagnose_recordings(delta, [record(late, loss)])
    found = {(f.effect, f.component): f.parameters["time"] for f in answer.findings}
    assert set(found) == {("sensor_latency", "sensors"), ("lost_steps", "motor2")}
    assert found["sensor_latency", "sensors"].value == pytest.approx(0.15, abs=0.02)
    assert found["lost_steps", "motor2"].value == pytest.approx(22.0, abs=0.06)
    low, high = np.ravel(found["lost_steps", "motor2"].ci95)
    assert low - 0.06 <= 22.0 <= high + 0.06


def test_a_stuck_sensor_is_seen(delta: DeltaRobot, record: Record) -> None:
    recording = record()
    recording.columns["range_y"][1000:1150] = recording.columns["range_y"][1000]
    answer = diagnose_recordings(delta, [recording])
    assert [(f.effect, f.component) for f in answer.findings] == [("stale_reading", "range_y")]
    begin, end = answer.findings[0].where.times_s[0]
    assert begin == pytest.approx(recording.t_s[1000], abs=0.1)
    assert end == pytest.approx(recording.t_s[1149], abs=0.1)


def test_a_ripple_in_no_vocabulary_is_unknown(delta: DeltaRobot, record: Record) -> None:
    recording = record()
    covariate = recording.columns["range_z"]
    recording.columns["range_x"] += 0.004 * np.sin(2 * np.pi * covariate / 0.06)
    answer = diagnose_recordings(delta, [recording])
    assert [(f.effect, f.component) for f in answer.findings] == [("unknown", "range_x")]
    assert answer.findings[0].depends_on == ["range_z"]
    assert answer.verdict == "unexplained"


def test_the_same_recording_gives_the_same_answer(delta: DeltaRobot, record: Record) -> None:
    recording = record(_entry("home_offset", "motor1", angle=0.01), seconds=30.0)
    first, second = (diagnose_recordings(delta, [recording]).to_json() for _ in range(2))
    assert first == second
