"""Detection limits of play and of a delay, held against axes that have just so much of it."""

from __future__ import annotations

from dataclasses import replace
from statistics import median

import pytest

from deltactl.diagnosis.answer.records import Diagnosis
from deltactl.diagnosis.api import diagnose_recordings
from deltactl.models.robot import ServoAxis
from tests.axes.axis_rigs import FollowingRig

pytestmark = pytest.mark.study

SLIDE = ServoAxis(kind="servo_axis", name="slide", motion="linear", zero="absolute")
AXES = 4


def answer(rig: FollowingRig, seed: int) -> Diagnosis:
    return diagnose_recordings(SLIDE, [rig.record(seed, span_s=20.0)])


@pytest.fixture(scope="module")
def limits() -> dict[str, float]:
    """Of a sound axis: in the middle of three, as each depends on its noise."""
    sound = [answer(FollowingRig(), seed).smallest_detectable for seed in range(3)]
    return {
        effect: median(one.value for found in sound for one in found if one.effect == effect)
        for effect in ("gear_backlash", "joint_friction", "following_lag")
    }


@pytest.mark.parametrize(
    ("effect", "field"), [("gear_backlash", "play"), ("following_lag", "dead_s")]
)
def test_an_effect_at_its_limit_is_mostly_seen_and_at_half_of_it_mostly_not(
    limits: dict[str, float], effect: str, field: str
) -> None:
    """Neither had a limit: nobody could tell a sound axis from a recording that shows nothing."""

    def alarms(size: float) -> int:
        rig = replace(FollowingRig(), **{field: size})
        answers = [answer(rig, 100 + seed) for seed in range(AXES)]
        return sum(one.verdict != "nothing_missing" for one in answers)

    assert alarms(limits[effect]) >= 3
    assert alarms(0.5 * limits[effect]) <= 1


def test_play_and_friction_that_are_one_operator_have_one_limit(limits: dict[str, float]) -> None:
    assert limits["joint_friction"] == limits["gear_backlash"]
