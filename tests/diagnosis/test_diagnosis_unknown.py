"""What fits no effect is unknown, and says all that it may follow."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from deltactl.diagnosis.answer.records import Finding
from deltactl.diagnosis.api import diagnose_recordings
from deltactl.diagnosis.plants.delta.unknown import way
from deltactl.models.chain import Chain, Commands
from deltactl.models.robot import DeltaRobot, EffectEntry
from deltactl.recording.tables.flat import FlatRecording

pytestmark = pytest.mark.study

Record = Callable[..., FlatRecording]
RATE_HZ = 0.31
SIZE_M = 0.004
SIZE_RAD = 0.01


def _answer(delta: DeltaRobot, recording: FlatRecording) -> list[Finding]:
    return diagnose_recordings(delta, [recording]).findings


def _seen(delta: DeltaRobot, t_s: np.ndarray, rad: np.ndarray, error: np.ndarray) -> FlatRecording:
    """A recording of arms that are where `error` says beside what was commanded, (n, 3) each."""
    fresh = np.arange(len(t_s)) == 0
    moved = Chain.delta(delta).simulate(Commands.of_angles(t_s, rad + error, fresh), [])
    noise = 0.002 * np.random.default_rng(5).standard_normal((len(t_s), 3))
    ranges = np.round(moved.ranges + noise, 3)
    columns = {f"command_{j + 1}": rad[:, j] for j in range(3)}
    columns |= {f"range_{a}": ranges[:, i] for i, a in enumerate("xyz")}
    return FlatRecording(t_s, columns, {}, "synthetic")


def test_a_sway_follows_time(delta: DeltaRobot, record: Record) -> None:
    recording = record()
    recording.columns["range_x"] += SIZE_M * np.sin(2.0 * np.pi * RATE_HZ * recording.t_s)
    (finding,) = _answer(delta, recording)
    assert (finding.effect, finding.component) == ("unknown", "range_x")
    assert finding.depends_on == ["time"]
    size = finding.parameters["size_rms"].value
    assert size == pytest.approx(SIZE_M / np.sqrt(2.0), rel=0.1)


def test_the_size_is_of_where_something_was_read(delta: DeltaRobot, record: Record) -> None:
    """A sensor that gives nothing in the outer half of its way, and errs there no one knows how."""
    recording = record()
    seen = recording.columns["range_y"]
    turns = (seen - seen.min()) / np.ptp(seen)
    error = 0.01 * np.sin(2.5 * np.pi * turns) ** 3
    recording.columns["range_y"] = np.where(turns < 0.5, seen + error, np.nan)
    (finding,) = _answer(delta, recording)
    assert (finding.effect, finding.component) == ("unknown", "range_y")
    size = finding.parameters["size_rms"].value
    assert size == pytest.approx(np.std(error[turns < 0.5]), rel=0.1)


def test_play_that_differs_from_place_to_place(delta: DeltaRobot, record: Record) -> None:
    whole = record(seconds=60.0)
    assert delta.drive is not None
    rad = delta.drive.rad_per_step * np.stack([whole.columns[f"steps_{j}"] for j in (1, 2, 3)], 1)
    error = np.zeros_like(rad)
    error[:, 1] = -SIZE_RAD * np.sin(1.5 * rad[:, 1]) ** 4 * way(rad[:, 1])
    found = _answer(delta, _seen(delta, whole.t_s, rad, error))
    unknown = [f for f in found if f.effect == "unknown"]
    assert [f.component for f in unknown][:1] == ["motor2"]
    assert "theta_2" in unknown[0].depends_on
    assert unknown[0].has_memory


def test_what_follows_two_quantities_is_one_finding(delta: DeltaRobot, record: Record) -> None:
    """A sensor errs over its distance, and over how warm it is."""
    recording = record(seconds=60.0)
    seen, t_s = recording.columns["range_y"], recording.t_s
    turns = (seen - seen.min()) / np.ptp(seen)
    recording.columns["range_y"] = seen + SIZE_M * (
        np.sin(2.5 * np.pi * turns) ** 3 + np.sin(3.0 * np.pi * t_s / t_s[-1])
    )
    (finding,) = _answer(delta, recording)
    assert (finding.effect, finding.component) == ("unknown", "range_y")
    assert {"range_y", "time"} <= set(finding.depends_on)
    assert finding.table is None


def test_on_a_circle_the_angle_and_its_speed_are_tied(delta: DeltaRobot) -> None:
    """An error that follows the size of the speed follows the angle as well there."""
    t_s = 0.02 * np.arange(3000)
    turn = 2.0 * np.pi * t_s / 12.0
    rad = 0.6 + 0.2 * np.cos(turn[:, None] - np.radians([0.0, 120.0, 240.0]))
    error = np.zeros_like(rad)
    error[:, 0] = SIZE_RAD * np.tanh(np.abs(np.sin(turn)) / 0.3)
    (finding,) = _answer(delta, _seen(delta, t_s, rad, error))
    assert (finding.effect, finding.component) == ("unknown", "motor1")
    assert {"theta_1", "speed_1"} <= set(finding.depends_on)
    assert finding.tied
    assert "cannot tell which" in finding.says


@pytest.mark.parametrize(
    "effect",
    [
        EffectEntry(effect="gear_backlash", component="motor2", parameters={"width": 0.02}),
        EffectEntry(effect="joint_friction", component="motor2", parameters={"width": 0.02}),
    ],
    ids=lambda entry: entry.effect,
)
def test_plain_play_is_no_unknown(delta: DeltaRobot, record: Record, effect: EffectEntry) -> None:
    found = _answer(delta, record(effect, seconds=120.0))
    assert [(f.effect, f.component) for f in found] == [(effect.effect, "motor2")]
