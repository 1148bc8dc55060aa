"""The arm is at another angle than the robot file says when the count is 0."""

from __future__ import annotations

from deltactl.models.effects.card import (
    ByHand,
    Compensated,
    Confusion,
    Defect,
    Drawing,
    EffectCard,
    Group,
    Rule,
    Trait,
    Words,
)
from deltactl.models.effects.kind import (
    MOTORS,
    EffectKind,
    Parameter,
    Port,
    adds,
)
from deltactl.models.effects.units_in_use import said

EFFECT = EffectKind(
    name="home_offset",
    port=Port.ARM,
    components=MOTORS,
    parameters=(Parameter("angle", "rad", -0.6, 0.6, typical=0.01),),
    operate=adds("angles_rad", "angle"),
    says=lambda component, v: (
        f"at home the arm of {component} is {said(abs(v['angle']), 'rad')}"
        f" {'lower' if v['angle'] > 0.0 else 'higher'} than it should be"
    ),
    pose_alone=True,
)

CARD = EffectCard(
    name=EFFECT.name,
    kind=EFFECT,
    listed=0,
    on={"command": EFFECT},
    says={
        "": "the axis is {size} {sign:above|below} where it should be",
    },
    log_odds={
        # wears or is set by hand
        "command/offset": -1.0,
        "pose/home": -1.0,
    },
    words=Words(
        noun="a wrong home angle of {part}",
        axis="a wrong home position of {part}",
        several="wrong home angles of {part}",
        further="a further offset of {part}",
        regime="everywhere, as a constant angle of {part}",
        axis_regime="everywhere, as a constant",
    ),
    remedies={
        "": (
            "correct the home stop or jig of {part}: at home its arm is {size} "
            "{sign:lower|higher} than it should be; or enter the offset in the robot file"
        ),
        "chain/": (
            "{sign:add|take} {size} {sign:to|off} what the encoder of {part} reads: its zero is "
            "off by that; or write it into the model (`--save-robot`, then `deltactl export`)"
        ),
        "axis/": (
            "{sign:take|add} {size} {sign:off|to} the commands of {part}, or move its zero by as "
            "much: it is that far {sign:above|below} its command"
        ),
        "axis/beside": (
            "then look at the zero of {part} again: it is {size} {sign:above|below} its command, "
            "as it may be where the zero was set after coming from one side; {sign:take|add} "
            "what stays {sign:off|to} its commands"
        ),
    },
    drawing=Drawing(axis=("encoder",)),
    traits=frozenset({Trait.ENTERED, Trait.ZERO, Trait.SIGNED, Trait.WARMS}),
    rule=Rule.SUM,
    compensated=Compensated.INVERSE,
    confusions=(
        Confusion(
            "forearm_length",
            delta="A run through more of the workspace would distinguish them better.",
        ),
        Confusion(
            "sensor_offset",
            delta="A run with more tilted arms, or arm angles measured, would distinguish them.",
            by_hand=(
                "measure the height of the platform at home with a gauge, or an arm's angle with a "
                "level"
            ),
            effort=4,
        ),
    ),
    by_hand=ByHand("measure an arm's angle at home with a level", 4),
    group=Group("motors", 0),
    build_spread=0.002,  # rad, 0.1 deg: a stop or a switch that the arm is homed to
    defect=Defect("the home of motor 2 is off", "motor2", {"angle": 0.02}, 0),
    slide_names={"angle": "offset"},
)
