"""An upper arm or a forearm has another length than in the robot file."""

from __future__ import annotations

from dataclasses import replace

from deltactl.models.effects.card import (
    ByHand,
    Compensated,
    Defect,
    Drawing,
    EffectCard,
    Group,
    Rule,
    Trait,
    Words,
)
from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import (
    ARM_NAMES,
    EffectKind,
    Memory,
    Operate,
    Parameter,
    Port,
    Values,
    scalar,
)


def _lengthens(length: str) -> Operate:
    def operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
        length_m = flow.linkage[length].copy()
        length_m[..., index] += scalar(values, "length_error")
        flow.linkage[length] = length_m

    return operate


def _card(name: str, length: str, bar: str, listed: int) -> EffectCard:
    kind = EffectKind(
        name=name,
        port=Port.LINKAGE,
        components=ARM_NAMES,
        parameters=(Parameter("length_error", "m", -0.2, 0.2, typical=0.0015),),
        operate=_lengthens(length),
        says=lambda component, v: (
            f"the {bar} of {component} is {1e3 * abs(v['length_error']):.2f} mm too "
            f"{'long' if v['length_error'] > 0 else 'short'}"
        ),
        pose_alone=True,
    )
    return EffectCard(
        name=name,
        kind=kind,
        listed=listed,
        words=Words(
            noun=f"a wrong length of the {bar} of {{part}}",
            several=f"wrong {bar} lengths of {{part}}",
            regime="everywhere, with the pose",
        ),
        remedies={
            "": f"set the {bar} of {{part}} to {{true}} in the robot file, or replace it",
        },
        traits=frozenset({Trait.LENGTH, Trait.ENTERED, Trait.WARMS}),
        rule=Rule.SUM,
        compensated=Compensated.INVERSE,
        group=Group("arms", 4 + listed),
        length=length,
        build_spread=0.0005,  # m, between centres of joints glued, printed or drilled on a bench
    )


CARDS = (
    replace(
        _card("upper_arm_length", "upper_arm_m", "upper arm", 0),
        by_hand=ByHand("measure the upper arms from axis to joint", 2),
        defect=Defect("the upper arm of arm 3 is 2 % too long", "arm3", {"length_error": 0.02}, 3),
    ),
    replace(
        _card("forearm_length", "forearm_m", "forearm", 1),
        by_hand=ByHand("measure the rods from joint to joint", 1),
        drawing=Drawing(rod="forearm"),
    ),
)
