"""A servo that something pulls at while it holds, and a recording that begins within a move."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest

from benchmarks.proofs.contradictions import contradictions
from deltactl.diagnosis.answer.records import Diagnosis
from deltactl.diagnosis.api import diagnose_recordings
from deltactl.diagnosis.assessment.persistence import at_rest
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.lone.travel import ends_earlier_move
from deltactl.diagnosis.report.in_words import in_words
from deltactl.diagnosis.report.screen import sentences
from deltactl.models.robot import ServoAxis
from deltactl.recording.tables.flat import FlatRecording, from_columns

pytestmark = pytest.mark.study

ROBOT = ServoAxis(kind="servo_axis", name="stand", motion="rotary", zero="absolute")
COUNT_RAD = 2.0 * math.pi / 4096.0
PERIOD_S, HOLD_S = 0.1, 5.0
PLAY_RAD, SOFT_RAD_PER_NM, PULL_NM = 8.0 * COUNT_RAD, 14.0 * COUNT_RAD, 0.3
PLACES = (-100, 0, 100, 0, -100, 0, 100, 0)


def asked(places: Sequence[int]) -> FloatArray:
    """One place after the other, each held, (n,) [rad]."""
    rows = round(HOLD_S / PERIOD_S)
    return np.repeat(np.array(places, dtype=float) * COUNT_RAD, rows)


def pulled(t_s: FloatArray) -> FloatArray:
    """To one side and to the other in the second part of each rest, (n,) [N m]."""
    at = np.mod(t_s, HOLD_S)
    bump = np.clip(3.0 - 5.0 * np.abs(np.mod(at, 1.6) - 0.8), 0.0, 1.0)
    return np.where(at > 1.8, PULL_NM * bump * np.where(at < 3.4, 1.0, -1.0), 0.0)


def stand(came_from: float = PLACES[0], pulls: bool = True) -> FlatRecording:
    """200 Hz inside: a servo behind a dead time and a lag, play, a lever that gives way, counts.

    came_from: where the servo stood when the first place was commanded, in counts.
    """
    fine_s = 0.005
    t_s = np.arange(0.0, len(PLACES) * HOLD_S, fine_s)
    goal = np.repeat(asked(PLACES), round(PERIOD_S / fine_s))
    pull = pulled(t_s) if pulls else np.zeros(len(t_s))
    late = np.concatenate([np.full(40, came_from * COUNT_RAD), goal[:-40]])
    driven, side, seen = came_from * COUNT_RAD, 0.0, np.empty(len(t_s))
    axis = driven
    for k in range(len(t_s)):
        driven += (late[k] - driven) * fine_s / 0.09
        if abs(pull[k]) > 0.05:
            side = math.copysign(1.0, pull[k])
            axis = driven + 0.5 * PLAY_RAD * side
        axis = min(max(axis, driven - 0.5 * PLAY_RAD), driven + 0.5 * PLAY_RAD)
        seen[k] = axis + SOFT_RAD_PER_NM * pull[k]
    kept = slice(0, None, round(PERIOD_S / fine_s))
    columns = {
        "t": t_s[kept], "command": goal[kept], "load": pull[kept],
        "position": COUNT_RAD * np.round(seen[kept] / COUNT_RAD),
    }  # fmt: skip
    return from_columns(columns, "stand")


def without_load(recording: FlatRecording) -> FlatRecording:
    columns = {name: values for name, values in recording.columns.items() if name != "load"}
    return from_columns({"t": recording.t_s, **columns}, "stand")


@pytest.fixture(scope="module")
def unsaid() -> Diagnosis:
    """The answer where the recording does not say what pulls."""
    return in_words(diagnose_recordings(ROBOT, [without_load(stand())]))


def test_what_pulls_at_rest_and_is_not_recorded_is_not_called_noise(unsaid: Diagnosis) -> None:
    found = unsaid.fit.at_rest
    assert found is not None
    assert not found.load_known
    assert found.moved >= 0.5 * found.rests
    assert found.moved_by_m > PLAY_RAD
    text = " ".join(sentences(unsaid, ROBOT))
    assert "while its command is constant, the axis moves by up to" in text
    assert "Find out what moves the axis while its command is constant." in text
    assert "consistent with measurement noise" not in text
    assert "the noise alone" not in text
    assert not contradictions(unsaid)


def test_the_same_with_its_load_shows_the_play_behind_it() -> None:
    answer = in_words(diagnose_recordings(ROBOT, [stand()]))
    found = {one.effect: one for one in answer.findings}
    assert found["gear_backlash"].parameters["width"].value == pytest.approx(PLAY_RAD, rel=0.25)
    assert "joint_compliance" in found
    text = " ".join(sentences(answer, ROBOT))
    assert "while its command is constant" not in text
    # Under one load every reading of a rest is the same count: what is left is no noise of theirs.
    assert answer.fit.scatter_within_m == pytest.approx(COUNT_RAD / math.sqrt(12.0), rel=0.2)
    assert "consistent with measurement noise" not in text


def test_a_recording_may_begin_within_a_move() -> None:
    """Three rows of a move that no row commands outweighed all rests together."""
    whole, begun = (diagnose_recordings(ROBOT, [stand(at)]) for at in (PLACES[0], 0.0))
    assert begun.fit.rms_after_m == pytest.approx(whole.fit.rms_after_m, rel=0.15)
    widths = [
        next(f for f in one.findings if f.effect == "gear_backlash").parameters["width"].value
        for one in (whole, begun)
    ]
    assert widths[1] == pytest.approx(widths[0], rel=0.1)


@pytest.mark.parametrize(
    ("observed", "rows"),
    [
        ([9.0, 5.0, 2.0, 0.1, 0.0, 0.0, 0.0], 3),
        ([0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], 0),
        ([math.nan, 9.0, 5.0, 0.0, 0.0, 0.0, 0.0], 0),
        ([9.0, 9.0, 9.0, 9.0, 9.0, 9.0, 9.0], 0),
    ],
)
def test_only_rows_that_come_in_from_elsewhere_are_left_out(
    observed: list[float], rows: int
) -> None:
    """Not those of an axis that is somewhere else for good, nor where nobody saw it come."""
    t_s = PERIOD_S * np.arange(14.0)
    command = np.repeat([0.0, 10.0], 7)
    seen = np.array([*observed, *np.full(7, 10.0)])
    fresh = np.arange(14) == 0
    assert np.count_nonzero(ends_earlier_move(t_s, command, seen, fresh, 1e-3)) == rows


def test_an_axis_that_only_scatters_at_rest_does_not_move() -> None:
    rng = np.random.default_rng(1)
    stays = np.repeat([0, -1, 1, -1, 2, -1], 200)
    noise = rng.standard_normal(1200)
    quiet = at_rest(noise, stays, 0.0, load_known=False)
    assert quiet is not None
    assert (quiet.rests, quiet.moved) == (3, 0)
    steps = noise + 20.0 * (np.arange(1200) % 200 > 120) * (stays == 1)
    moved = at_rest(steps, stays, 0.0, load_known=False)
    assert moved is not None
    assert moved.moved == 1
    assert moved.moved_by_m == pytest.approx(20.0, rel=0.3)
    assert at_rest(noise[:203], stays[:203], 0.0, load_known=False) is None
