"""A joint's output follows the drive's following error, as behind a gear that winds up."""

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
        noun="an output of {part} that differs from its encoder by the following error",
        several="outputs of {part} that differ from their encoders by the following errors",
        regime="where {part} is short of its command",
        axis_regime="where it is short of its command",
    ),
    remedies={
        "": (
            "look for what gives way between encoder and output of {part}, or for an encoder that "
            "reads late: its output goes on by {size} times the following error"
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
