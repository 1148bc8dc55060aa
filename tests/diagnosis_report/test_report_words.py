"""Words of a report fit the machine: an axis has no platform, and need not turn."""

from __future__ import annotations

import re

import pytest

from deltactl.diagnosis.answer.records import ParameterResult
from deltactl.diagnosis.report.names import effect
from deltactl.diagnosis.report.remedies import LAYERS
from deltactl.diagnosis.report.sizes import sizes
from deltactl.models.effects import card_of
from deltactl.models.effects.kind import EffectKind
from deltactl.models.effects.lone_axis import command_effects, effort_effects, sensor_effects

OF_A_DELTA = re.compile(r"platform|\barms?\b|forearm|all joints")
OF_STEPPERS = re.compile(r"microstep|stop or jig|\bjobs\b|deltactl status sensors")
ROTARY = re.compile(r"\bangle|\bturns?\b")
TYPICAL = 0.1


def said(kind: EffectKind, component: str, *machines: str) -> list[str]:
    """All that a report may say of one effect at one component of these machines."""
    values = {one.name: TYPICAL for one in kind.parameters}
    card = card_of(kind.name)
    rows = ("", "small", "width")
    texts = [card.remedy(LAYERS[machine], (row,)) or "" for machine in machines for row in rows]
    return [effect(kind.name, component), kind.sentence(component, values), *texts]


@pytest.mark.parametrize("motion", ["rotary", "linear"])
def test_a_lone_axis_is_told_in_words_of_its_own(motion: str) -> None:
    kinds = [*command_effects(motion).values(), *effort_effects(motion).values()]
    assert len(kinds) > 15
    for kind in kinds:
        for text in said(kind, "axis", "servo_axis" if motion == "rotary" else "slide"):
            assert not OF_A_DELTA.search(text)
            assert not OF_STEPPERS.search(text) or kind.name == "lost_steps"
            assert motion == "rotary" or not ROTARY.search(text)


def test_a_range_sensor_has_no_robot() -> None:
    for kind in sensor_effects().values():
        for component in kind.components:
            assert not any(
                OF_A_DELTA.search(text) for text in said(kind, component, "range_sensor")
            )
            assert "axis" not in effect(kind.name, component)


def test_all_joints_are_not_named_again_one_by_one() -> None:
    every = effect("joint_compliance", "joints", "motor1", "motor2", "motor3")
    assert every == "shafts of all joints that yield under load"
    some = effect("joint_compliance", "joints", "motor1")
    assert some == "shafts of all joints and motor 1 that yield under load"


def test_the_same_effects_of_a_delta_keep_its_words() -> None:
    assert effect("resonance", "platform") == "ringing of the platform after moves"
    assert effect("home_offset", "motor2") == "a wrong home angle of motor 2"


def test_an_axis_that_slides_stands_off_by_a_length() -> None:
    found = ParameterResult(value=0.002, ci95=[0.001, 0.003], unit="m")
    assert sizes("home_offset", "angle", found)[0].name == "offset"
    turned = found.model_copy(update={"unit": "rad"})
    assert sizes("home_offset", "angle", turned)[0].name == "angle"
