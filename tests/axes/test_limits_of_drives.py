"""Limits of speed and of effort: named and sized, silent within them, and known afterwards."""

from __future__ import annotations

from collections.abc import Iterator
from types import ModuleType

import numpy as np
import pytest

from deltactl.diagnosis.answer.records import Diagnosis
from deltactl.diagnosis.api import diagnose_recordings
from deltactl.diagnosis.report.summary import plain_lines
from deltactl.models.effects import CARDS, register
from deltactl.models.effects.card import ByOperator, EffectCard, Words
from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import EffectKind, Memory, Parameter, Port, Values, scalar
from deltactl.models.robot import EffectEntry, ServoAxis

FOLLOWS = ServoAxis(kind="servo_axis", name="follows", motion="rotary")
FORCED = ServoAxis(kind="servo_axis", name="forced", motion="linear", inertia=2.0)


def check_named(answer: Diagnosis, effect: str, truth: float) -> None:
    """The only finding, with an interval that holds the truth or misses it by half its width."""
    assert [one.effect for one in answer.findings] == [effect]
    ((value, low, high),) = answer.findings[0].parameters["limit"].components
    assert low - 0.5 * (high - low) < truth < high + 0.5 * (high - low)
    assert value == pytest.approx(truth, rel=0.02)


@pytest.mark.parametrize("fastest", [0.3, 0.6])
def test_a_limit_of_the_speed_is_named_and_sized(rigs: ModuleType, fastest: float) -> None:
    answer = diagnose_recordings(FOLLOWS, [rigs.FollowingRig(fastest=fastest).record(3)])
    check_named(answer, "speed_limit", fastest)
    assert "no faster than" in "\n".join(plain_lines(answer, FOLLOWS))


def test_a_lag_beside_a_limit_of_the_speed_is_named_too(rigs: ModuleType) -> None:
    rig = rigs.FollowingRig(fastest=0.4, lag_s=0.08)
    answer = diagnose_recordings(FOLLOWS, [rig.record(4)])
    assert {one.effect for one in answer.findings} >= {"speed_limit", "following_lag"}


def test_a_limit_that_is_never_reached_is_not_named(rigs: ModuleType) -> None:
    answer = diagnose_recordings(FOLLOWS, [rigs.FollowingRig(fastest=3.0).record(3)])
    assert answer.verdict == "nothing_missing"


def test_a_limit_of_the_effort_is_named_and_sized(rigs: ModuleType) -> None:
    asked = rigs.ForcedRig().record(5).columns["effort"]
    strongest = 0.95 * float(np.max(np.abs(asked)))
    answer = diagnose_recordings(FORCED, [rigs.ForcedRig(strongest=strongest).record(5)])
    check_named(answer, "effort_limit", strongest)


def test_a_limit_that_the_file_has_is_no_finding(rigs: ModuleType) -> None:
    known = EffectEntry(effect="speed_limit", component="axis", parameters={"limit": 0.4})
    robot = FOLLOWS.model_copy(update={"effects": (known,)})
    answer = diagnose_recordings(robot, [rigs.FollowingRig(fastest=0.4).record(6)])
    assert answer.findings == []


# ---- any effect by its operator ----------------------------------------------------------------


def _stopped(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    flow.angles_rad = np.minimum(flow.angles_rad, scalar(values, "end"))


STOP = EffectKind(
    name="end_stop",
    port=Port.ARM,
    components=("axis",),
    parameters=(Parameter("end", "rad", 1e-6, 1e3, reciprocal=True),),
    operate=_stopped,
    says=lambda component, v: f"{component} goes no further than {v['end']:.3f} rad",
    nothing=float("inf"),
)
CARD = EffectCard(
    name=STOP.name,
    on={"command": STOP},
    log_odds={"command/end_stop": -3.0},
    by_operator={
        "command": ByOperator(
            lambda flow: (float(flow.angles_rad.max()), 0.1 * float(flow.angles_rad.max()))
        )
    },
    words=Words(noun="an end stop of {part}"),
    remedies={"": "move the end stop of {part} out of the way"},
)


@pytest.fixture
def added() -> Iterator[None]:
    """A card that nothing but this test names."""
    register([CARD])
    yield
    del CARDS[CARD.name]


def test_an_effect_of_an_axis_is_its_card_alone(rigs: ModuleType, added: None) -> None:
    recording = rigs.FollowingRig().record(7)
    position = recording.columns["position"]
    end = 0.7 * float(position.max())
    recording.columns["position"] = np.minimum(position, end)
    answer = diagnose_recordings(FOLLOWS, [recording])
    assert "end_stop" in {one.effect for one in answer.findings}
    ((value, *_),) = next(
        one.parameters["end"].components for one in answer.findings if one.effect == "end_stop"
    )
    assert value == pytest.approx(end, rel=0.02)
    assert "Move the end stop of the axis out of the way" in "\n".join(plain_lines(answer, FOLLOWS))
