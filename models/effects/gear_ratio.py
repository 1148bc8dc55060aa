"""The gear turns the arm by another amount per commanded angle than in the robot file."""

from __future__ import annotations

from deltactl.models.effects.card import (
    Compensated,
    Confusion,
    Defect,
    Drawing,
    EffectCard,
    Group,
    Rule,
    StandIn,
    Trait,
    Words,
)
from deltactl.models.effects.kind import (
    MOTORS,
    EffectKind,
    Parameter,
    Port,
    scales,
)

EFFECT = EffectKind(
    name="gear_ratio",
    port=Port.GEAR,
    components=MOTORS,
    parameters=(Parameter("scale", "1", 0.2, 5.0, starts=(1.0,), typical=0.005),),
    operate=scales("angles_rad", "scale"),
    says=lambda component, v: (
        f"the drive of {component} turns the arm {100 * (v['scale'] - 1):+.2f} % "
        "per commanded angle against the robot file"
    ),
    nothing=1.0,
    pose_alone=True,
)

CARD = EffectCard(
    name=EFFECT.name,
    kind=EFFECT,
    listed=0,
    on={"command": EFFECT},
    says={
        "": "the axis moves {scale} times as far as commanded",
    },
    log_odds={
        # teeth are counted, but microsteps and gears are typed into a file
        "stepper/ratio": -2.0,
        # a servo closes its loop over what is read: only another encoder sees another ratio
        "servo/ratio": -3.0,
        # a joint's teeth are counted, and its encoder has a known number of lines
        "pose/ratio": -4.0,
    },
    words=Words(
        noun="a wrong gear ratio of {part}",
        axis="a wrong ratio between command and motion of {part}",
        several="wrong gear ratios of {part}",
        further="a further error of the ratio of {part}",
        regime="in proportion to the angle of {part}",
        axis_regime="in proportion to the position",
    ),
    remedies={
        "": (
            "compare gear and microstep switches of {part} with the robot file: it moves {size} "
            "{sign:further|less far} than commanded"
        ),
        "small": (
            "enter the ratio of {part} in the robot file: it moves {size} {sign:further|less far} "
            "than commanded; that is too little for a wrong gear or microstep switch"
        ),
        "servo_drive/": (
            "compare the gear of {part}, and the counts per turn of its encoder, with the robot "
            "file: it moves {size} {sign:further|less far} than commanded"
        ),
        "servo_drive/small": (
            "enter the ratio of {part} in the robot file: it moves {size} {sign:further|less far} "
            "than commanded; that is too little for a wrong gear or count of the encoder"
        ),
        "axis/small": (
            "divide the commands of {part} by {factor}, or correct the scale in its drive: it moves"
            " {size} {sign:further|less far} than commanded"
        ),
        "servo_axis/": (
            "divide the commands of {part} by {factor}, or correct the scale by which its drive or "
            "program turns angles into counts: it moves {size} {sign:further|less far} than "
            "commanded"
        ),
        "slide/": (
            "compare steps per mm (or counts), the lead of the screw, and the teeth and pitch of "
            "belt and pulley of {part} with what is set: it moves {size} {sign:further|less far} "
            "than commanded"
        ),
        "slide/small": (
            "divide the steps per mm (or counts) of {part} by {factor}: it moves {size} "
            "{sign:further|less far} than commanded; a stretched belt and a screw's lead are off by"
            " as little"
        ),
    },
    small=0.02,
    drawing=Drawing(motor="gear", axis=("gear",)),
    traits=frozenset({Trait.ENTERED, Trait.RATIO, Trait.SIGNED}),
    rule=Rule.PRODUCT,
    compensated=Compensated.INVERSE,
    confusions=(
        Confusion(
            "joint_compliance",
            stands_in={
                # yielding is commoner, but a file without a weight is mostly of an axis with none
                "loaded/ratio": StandIn(0.0),
            },
            axis=(
                "{say_what_pulls}measure how far it moves between two places, with its load and "
                "without: a wrong ratio stays, what yields does not"
            ),
        ),
        Confusion(
            "sensor_scale",
            stands_in={
                # devices that measure are calibrated, though their figures are typed in too
                "linear/ratio": StandIn(-2.0),
            },
            axis=(
                "measure one long move of the axis by other means (gauge blocks, a tape, a second "
                "encoder)"
            ),
            called="a wrong scale of what measures {part}",
        ),
        Confusion(
            "unknown",
            stands_in={
                # what it rests on, or its clock, drifts about as often as a ratio is typed wrong
                "steady/ratio": StandIn(0.0),
            },
            axis=(
                "record again at another speed: the error of a wrong ratio grows with the way, a "
                "drift (of the base of the axis, of its clock) with the time"
            ),
            called="a drift of {part} with time",
        ),
    ),
    group=Group("motors", 2),
    build_spread=0.001,  # 1: teeth are counted, belts stretch
    defect=Defect("the gear ratio of motor 3 is 2 % off", "motor3", {"scale": 1.02}, 4),
)
