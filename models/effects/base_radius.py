"""Base minus platform radius differs from the file; only the difference can be seen."""

from __future__ import annotations

from deltactl.models.effects.card import ByHand, Compensated, EffectCard, Rule, Trait, Words
from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import EffectKind, Memory, Parameter, Port, Values, scalar


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    flow.linkage["radius_m"] = flow.linkage["radius_m"] + scalar(values, "length_error")


EFFECT = EffectKind(
    name="base_radius",
    port=Port.LINKAGE,
    components=("frame",),
    parameters=(Parameter("length_error", "m", -0.3, 0.3, typical=0.002),),
    operate=_operate,
    says=lambda component, v: (
        f"base radius minus platform radius is {1e3 * v['length_error']:+.2f} mm off"
    ),
    pose_alone=True,
)

CARD = EffectCard(
    name=EFFECT.name,
    kind=EFFECT,
    listed=2,
    words=Words(
        noun="a wrong radius of the base or the platform",
        regime="everywhere, with the pose",
    ),
    remedies={
        "": "measure base and platform: the difference of their radii is {true}",
    },
    traits=frozenset({Trait.LENGTH, Trait.ENTERED, Trait.WARMS}),
    rule=Rule.SUM,
    compensated=Compensated.INVERSE,
    by_hand=ByHand(
        (
            "measure the radii of base and platform with calipers (their difference is all that "
            "the linkage shows)"
        ),
        0,
    ),
    length="radius_m",
    build_spread=0.001,  # m, the difference of two radii
)
