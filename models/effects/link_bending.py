"""A bearing or a link of a chain bends across the joint's axis under weight."""

from __future__ import annotations

from deltactl.models.effects.card import (
    Compensated,
    Confusion,
    Drawing,
    EffectCard,
    Rule,
    Trait,
    Words,
)

CARD = EffectCard(
    name="link_bending",
    log_odds={
        # bearings and castings are stiffer than the gears that hold them
        "pose/bend": -3.0,
    },
    words=Words(
        noun="a bearing or link at {part} that bends under weight",
        several="bearings or links at {part} that bend under weight",
        regime="where the weight across the axis of {part} is large",
        axis_regime="where the weight is large",
    ),
    remedies={
        "": (
            "look for loose screws and a worn bearing at {part}; where it is its build, enter what "
            "was found in the robot file"
        ),
    },
    drawing=Drawing(everywhere=("link",)),
    traits=frozenset({Trait.UNDER_LOAD, Trait.BEHIND_READING}),
    rule=Rule.SUM,
    compensated=Compensated.INVERSE,
    confusions=(
        Confusion(
            "joint_compliance",
            axis="measure poses with a known weight at the tool",
        ),
    ),
)
