"""A joint is nearer its command than its encoder says (or, below zero, farther from it): its gear
winds up with what the drive pulls, or the encoder is the noisier of both.
"""

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
    name="drive_windup",
    log_odds={
        # a drive that is short of its command pushes, and what it pushes through gives way
        "pose/windup": -2.5,
    },
    words=Words(
        noun="a position of {part} between its encoder and its command",
        several="positions of {part} between their encoders and their commands",
        regime="where {part} is short of its command",
        axis_regime="where it is short of its command",
    ),
    remedies={
        "": (
            "look for what gives way between encoder and output of {part}, or for an encoder that "
            "is noisy or read late: {part} is nearer its command by {size} of the following error"
        ),
    },
    drawing=Drawing(axis=("gear",)),
    traits=frozenset({Trait.BEHIND_READING}),
    rule=Rule.SUM,
    compensated=Compensated.NOT,
    confusions=(
        Confusion(
            "joint_compliance",
            axis="measure poses with a known weight at the tool",
        ),
    ),
)
