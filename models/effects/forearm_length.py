"""The forearm has another length than believed."""

from __future__ import annotations

from deltactl.models.effects.card import (
    ByHand,
    Compensated,
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
    Parameter,
    Port,
    Values,
    scalar,
)


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    length_m = flow.linkage["forearm_m"].copy()
    length_m[..., index] += scalar(values, "length_error")
    flow.linkage["forearm_m"] = length_m


EFFECT = EffectKind(
    name="forearm_length",
    port=Port.LINKAGE,
    components=ARM_NAMES,
    parameters=(Parameter("length_error", "m", -0.2, 0.2, typical=0.0015),),
    operate=_operate,
    says=lambda component, v: (
        f"the forearm of {component} is {1e3 * abs(v['length_error']):.2f} mm too "
        f"{'long' if v['length_error'] > 0 else 'short'}"
    ),
    pose_alone=True,
)

CARD = EffectCard(
    name=EFFECT.name,
    kind=EFFECT,
    listed=1,
    words=Words(
        noun="a wrong length of the forearm of {part}",
        several="wrong forearm lengths of {part}",
        regime="everywhere, with the pose",
    ),
    remedies={
        "": "set the forearm of {part} to {true} in the robot file, or replace it",
    },
    drawing=Drawing(rod="forearm"),
    traits=frozenset({Trait.LENGTH, Trait.ENTERED}),
    rule=Rule.SUM,
    compensated=Compensated.INVERSE,
    by_hand=ByHand("measure the rods from joint to joint", 1),
    group=Group("arms", 5),
    length="forearm_m",
    build_spread=0.0005,  # m, between centres of joints glued, printed or drilled on a bench
)
