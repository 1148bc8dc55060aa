"""Intervals have room for what no robot file can promise."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from deltactl.diagnosis.api import diagnose_recordings
from deltactl.diagnosis.assessment.intervals import NORMAL_95
from deltactl.models.chain import Chain, Commands
from deltactl.models.robot import DeltaRobot, EffectEntry
from deltactl.recording.tables.flat import FlatRecording

pytestmark = pytest.mark.study

Record = Callable[..., FlatRecording]
MOUNTED_M, HOMED_RAD, GIVES_WAY_M = 0.025e-3, 0.03e-3, 0.25e-3


def _half(delta: DeltaRobot, recording: FlatRecording, effect: str, name: str) -> float:
    """Half the interval of a size of the one finding."""
    (finding,) = diagnose_recordings(delta, [recording]).findings
    assert finding.effect == effect
    ((_, low, high),) = finding.parameters[name].components
    return 0.5 * (high - low)


def _quiet(delta: DeltaRobot, record: Record, effect: EffectEntry) -> FlatRecording:
    """Sensors that are 40 times as good as usual."""
    moved = record(seconds=24.0)
    counts = np.stack([moved.columns[f"steps_{j}"] for j in (1, 2, 3)], axis=1)
    assert delta.drive is not None
    commands = Commands.of_counts(moved.t_s, counts, delta.drive)
    ranges = Chain(delta).simulate(commands, [effect]).ranges
    ranges = ranges + 5e-5 * np.random.default_rng(3).standard_normal(ranges.shape)
    columns = {f"steps_{j + 1}": counts[:, j] for j in range(3)}
    columns |= {f"range_{a}": ranges[:, i] for i, a in enumerate("xyz")}
    return FlatRecording(moved.t_s, columns, {}, "quiet")


@pytest.mark.parametrize(
    ("effect", "component", "name", "size", "least"),
    [
        ("sensor_offset", "range_z", "offset", 0.005, MOUNTED_M),
        ("home_offset", "motor1", "angle", 0.01, HOMED_RAD),
    ],
)
def test_no_size_is_surer_than_the_best_machine_is_built(
    delta: DeltaRobot,
    record: Record,
    effect: str,
    component: str,
    name: str,
    size: float,
    least: float,
) -> None:
    hidden = EffectEntry(effect=effect, component=component, parameters={name: size})
    half = _half(delta, _quiet(delta, record, hidden), effect, name)
    assert NORMAL_95 * least < half < 0.2 * size


def test_an_interval_has_room_for_what_a_stop_gives_way(delta: DeltaRobot, record: Record) -> None:
    stop = EffectEntry(effect="contact", component="platform", parameters={"height": -0.44})
    half = _half(delta, record(stop, seconds=30.0), "contact", "height")
    assert NORMAL_95 * GIVES_WAY_M < half < 3e-3
