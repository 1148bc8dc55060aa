"""The upper arm has another length than believed."""

from __future__ import annotations

from deltactl.models.effects.card import (
    ByHand,
    Compensated,
    Defect,
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
    Parameter,
    Port,
    Values,
    scalar,
)


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    length_m = flow.linkage["upper_arm_m"].copy()
    length_m[..., index] += scalar(values, "length_error")
    flow.linkage["upper_arm_m"] = length_m


EFFECT = EffectKind(
    name="upper_arm_length",
    port=Port.LINKAGE,
    components=ARM_NAMES,
    parameters=(Parameter("length_error", "m", -0.2, 0.2, typical=0.0015),),
    operate=_operate,
    says=lambda component, v: (
        f"the upper arm of {component} is {1e3 * abs(v['length_error']):.2f} mm too "
        f"{'long' if v['length_error'] > 0 else 'short'}"
    ),
    pose_alone=True,
)

CARD = EffectCard(
    name=EFFECT.name,
    kind=EFFECT,
    listed=0,
    words=Words(
        noun="a wrong length of the upper arm of {part}",
        several="wrong upper arm lengths of {part}",
        regime="everywhere, with the pose",
    ),
    remedies={
        "": "set the upper arm of {part} to {true} in the robot file, or replace it",
    },
    traits=frozenset({Trait.LENGTH, Trait.ENTERED}),
    rule=Rule.SUM,
    compensated=Compensated.INVERSE,
    by_hand=ByHand("measure the upper arms from axis to joint", 2),
    group=Group("arms", 4),
    length="upper_arm_m",
    build_spread=0.0005,  # m, between centres of joints glued, printed or drilled on a bench
    defect=Defect("the upper arm of arm 3 is 2 % too long", "arm3", {"length_error": 0.02}, 3),
)
