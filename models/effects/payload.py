"""A load on the platform bears the joints down; how far depends on their stiffness."""

from __future__ import annotations

from deltactl.models.effects.card import ByHand, Compensated, Drawing, EffectCard, Rule, Words
from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import (
    Discrepancy,
    EffectKind,
    Memory,
    Parameter,
    Port,
    Values,
    scalar,
)


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    yields = scalar(values, "mass") / scalar(values, "stiffness")
    flow.angles_rad += flow.load.per_kg_nm * yields


OF_MASS = 0.1
"""Usual load as a share of what moves: arms carry a tenth to a third of what they weigh."""
OFF_OF_REACH = 0.1
"""Usual distance of its centre from the end of the last link, as a share of the reach."""

EFFECT = EffectKind(
    name="payload",
    port=Port.GEAR,
    components=("platform",),
    parameters=(
        Parameter("mass", "kg", -0.5, 50.0, step=0.05, typical=0.3),
        Parameter("stiffness", "N m/rad", 1.0, 1e12, starts=(500.0,), default=500.0),
    ),
    operate=_operate,
    says=lambda component, v: (
        f"the platform carries {v['mass']:.3g} kg more than the robot file says "
        f"(if the joints have {v['stiffness']:.4g} N m/rad)"
    ),
    order=6,
    # acts through compliance; inertia on a spring rings
    discrepancy=Discrepancy(0.012, 0.012, leads_to={"resonance": 1.0}),
    # compliance does nearly the same, and is the commoner
    penalty=12.0,
)

CARD = EffectCard(
    name=EFFECT.name,
    kind=EFFECT,
    listed=6,
    log_odds={
        # changed by hand, and not always in the file
        "joint": -1.5,
    },
    words=Words(
        noun="a wrong mass at {part}",
        regime="everywhere, in proportion to the load on the joints",
        axis_regime="at all joints, with weight and acceleration of what is carried",
        sizes={"mass": "mass beyond the robot file's"},
    ),
    remedies={
        "chain/": "weigh what {part} carries: it is {size} {sign:more|less} than the model says",
        "": (
            "weigh what the platform carries: it is {size} {sign:more|less} than the robot file "
            "says"
        ),
    },
    drawing=Drawing(axis=("load",)),
    rule=Rule.RATE,
    compensated=Compensated.INVERSE,
    by_hand=ByHand("weigh the platform with all it carries", 3),
)
