"""A motor is mounted in another direction about the vertical than in the robot file."""

from __future__ import annotations

from deltactl.models.effects.card import ByHand, Compensated, EffectCard, Group, Rule, Trait, Words
from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import MOTORS, EffectKind, Memory, Parameter, Port, Values, scalar
from deltactl.models.effects.units_in_use import said


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    azimuth_rad = flow.linkage["azimuth_rad"].copy()
    azimuth_rad[..., index] += scalar(values, "angle")
    flow.linkage["azimuth_rad"] = azimuth_rad


EFFECT = EffectKind(
    name="motor_azimuth",
    port=Port.LINKAGE,
    components=MOTORS,
    parameters=(Parameter("angle", "rad", -0.6, 0.6, typical=0.01),),
    operate=_operate,
    says=lambda component, v: (
        f"{component} is mounted {'+' * (v['angle'] > 0.0)}{said(v['angle'], 'rad')}"
        " off its direction"
    ),
    pose_alone=True,
)

CARD = EffectCard(
    name=EFFECT.name,
    kind=EFFECT,
    listed=3,
    words=Words(
        noun="a wrong direction of {part} around the base",
        several="wrong directions of {part} around the base",
        regime="everywhere, sideways of {part}",
    ),
    remedies={
        "": "turn {part} on the base, it is {size} off; or enter the angle in the robot file",
    },
    traits=frozenset({Trait.ENTERED}),
    rule=Rule.SUM,
    compensated=Compensated.INVERSE,
    by_hand=ByHand("measure the distances between the motor axes on the base plate", 5),
    group=Group("motors", 3),
    build_spread=0.003,  # rad: 1 mm on a base of 325 mm
)
