"""Errors that repeat with the position in more detail than a gear's: teeth, and maps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter

from benchmarks.proofs.contradictions import contradictions
from deltactl.diagnosis.answer.records import Diagnosis
from deltactl.diagnosis.api import diagnose_recordings
from deltactl.diagnosis.assessment.options import ASSESSMENT
from deltactl.diagnosis.evidence.repeats import repeats
from deltactl.diagnosis.plants.lone.waves import resolved_waves
from deltactl.diagnosis.report.in_words import in_words
from deltactl.diagnosis.report.remedies import remedies
from deltactl.models.robot import ServoAxis
from deltactl.recording.tables.flat import FlatRecording, from_columns

pytestmark = pytest.mark.study

SLIDE = ServoAxis(kind="servo_axis", name="slide", motion="linear")
JOINT = ServoAxis(kind="servo_axis", name="joint", motion="rotary")
TRAVEL_M = 0.04


@dataclass(frozen=True)
class ScaleRig:
    """A slide that goes to and fro at one speed, with rests, under a sensor whose scale is rough.

    rough: standard deviation of the error at points 0.2 mm apart, cosine curves between them.
    """

    rough: float = 8e-6
    noise: float = 5e-7
    travel: float = TRAVEL_M
    ratio: float = 1.0
    memory: float = 0.0
    """Correlation of the noise from one reading to the next."""

    def record(self, seed: int, passes: int = 6) -> FlatRecording:
        """t, command and position at 2 Hz; the error is the same for all seeds."""
        points = self.rough * np.random.default_rng(77).standard_normal(int(TRAVEL_M / 2e-4) + 2)
        rng = np.random.default_rng(seed)
        there, rest = np.linspace(0.0, self.travel, 200), 40
        command = np.concatenate(
            [np.append(way, np.full(rest, way[-1])) for way in [there, there[::-1]] * (passes // 2)]
        )
        t_s = 0.5 * np.arange(len(command))
        axis = command + rng.uniform(0.0, 2e-4) * (np.diff(command, prepend=0.0) != 0.0)
        number = (axis / 2e-4).astype(int)
        bend = 0.5 - 0.5 * np.cos(np.pi * (axis / 2e-4 - number))
        error = points[number] + (points[number + 1] - points[number]) * bend
        new = np.sqrt(1.0 - self.memory**2) * rng.standard_normal(len(axis))
        noise = self.noise * lfilter([1.0], [1.0, -self.memory], new)
        seen = self.ratio * axis + error + noise
        return from_columns({"t": t_s, "command": axis, "position": seen}, "rig")


@pytest.fixture(scope="module")
def rough() -> Diagnosis:
    rig = ScaleRig()
    return in_words(diagnose_recordings(SLIDE, [rig.record(1)], [rig.record(2, passes=4)]))


def test_a_rough_scale_is_mapped_in_the_detail_that_repeats(rough: Diagnosis) -> None:
    unknown = rough.findings[-1]
    assert (unknown.effect, unknown.depends_on) == ("unknown", ["position"])
    assert unknown.parameters["size_rms"].components[0][0] == pytest.approx(8e-6 * 0.8, rel=0.3)
    assert rough.fit.holdout_rms_after_m < 0.6 * rough.fit.holdout_rms_before_m
    assert "transmission_error" not in {one.effect for one in rough.findings}
    assert not contradictions(rough)


def test_the_odds_of_what_stands_beside_a_map_agree_with_its_probability() -> None:
    """A map has more pieces than readings are independent: once "noise alone would look like this
    in nearly all recordings" stood beside a probability above 99 %.
    """
    rig = ScaleRig(rough=3e-5, noise=3e-6, ratio=0.996, memory=0.9)
    answer = diagnose_recordings(SLIDE, [rig.record(1, passes=4)], [])
    chances = {one.effect: one.evidence.p for one in answer.findings}
    assert chances["gear_ratio"] < 1e-6
    assert max(chances.values()) <= ASSESSMENT.unlikely
    assert answer.false_alarm_p < 1e-6


def test_the_map_is_in_the_answer_and_the_advice_says_what_to_do_with_it(rough: Diagnosis) -> None:
    table = rough.findings[-1].table
    assert table is not None
    assert table.follows == "position"
    assert len(table.size) > 90
    (line,) = [line for line in remedies(rough, SLIDE) if "table" in line]
    assert f"{len(table.size)} points" in line


def test_what_is_more_than_readings_at_rest_scatter_by_is_not_called_their_noise() -> None:
    """A wobble of the machine in motion that follows nothing, and readings of 0.5 um."""
    recording = ScaleRig(rough=0.0).record(3)
    moving = np.diff(recording.columns["command"], prepend=-1.0) != 0.0
    wobble = 2e-5 * np.random.default_rng(4).standard_normal(len(recording)) * moving
    columns = {"t": recording.t_s, **recording.columns}
    columns["position"] = columns["position"] + wobble
    answer = in_words(diagnose_recordings(SLIDE, [from_columns(columns, "rig")]))
    assert answer.fit.scatter_within_m == pytest.approx(5e-7, rel=0.5)
    assert " in motion" in answer.unexplained.says
    assert "consistent with measurement noise" not in answer.unexplained.says


@pytest.mark.parametrize("rho", [0.0, 0.9, 0.97])
def test_noise_repeats_nowhere_however_long_its_memory(rigs: Any, rho: float) -> None:
    for seed in range(5):
        recording = rigs.FollowingRig(rho=rho).record(seed, span_s=30.0)
        left = recording.columns["position"] - recording.columns["command"]
        groups = np.zeros(len(left), dtype=np.intp)
        assert repeats(left, recording.columns["command"], groups, len(left) / 3.0) is None


def test_teeth_far_finer_than_a_wheels_turn_are_found(rigs: Any) -> None:
    rig = rigs.FollowingRig(wave=1e-3, period=0.0055)
    answer = diagnose_recordings(JOINT, [rig.record(5)])
    (teeth,) = [one for one in answer.findings if one.effect == "transmission_error"]
    assert teeth.parameters["period"].components[0][0] == pytest.approx(0.0055, rel=0.01)
    assert teeth.parameters["amplitude"].components[0][0] == pytest.approx(1e-3, rel=0.2)


@pytest.mark.parametrize(
    ("places", "most"),
    [
        (np.linspace(0.0, 1.0, 9), 2.25),
        (np.repeat(np.linspace(0.0, 1.0, 9), 50), 2.25),
        (np.linspace(0.0, 1.0, 401), 100.25),
        (np.random.default_rng(0).uniform(0.0, 1.0, 800), 200.0),
    ],
)
def test_places_not_rows_say_how_fine_a_wave_shows(places: Any, most: float) -> None:
    assert resolved_waves(places, 1.0, 0.0) == pytest.approx(most, rel=0.06)
