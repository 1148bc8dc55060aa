"""Shafts and arms yield under the gravity torque at the joint."""

from __future__ import annotations

from deltactl.models.effects.card import (
    Compensated,
    Confusion,
    Coordinate,
    Drawing,
    EffectCard,
    Fit,
    Rule,
    Shape,
    StandIn,
    Trait,
    Words,
)
from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import (
    MOTORS,
    Discrepancy,
    EffectKind,
    Memory,
    Parameter,
    Port,
    Values,
    joints,
    scalar,
)


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    part = joints(index)
    torque = flow.load.torque_nm[:, part]
    if flow.late_s > 0.0:  # a drive gives way as it follows: by the same time constant
        torque = flow.behind(torque, 0.0, flow.late_s, memory)
    flow.angles_rad[:, part] += torque / scalar(values, "stiffness")


EFFECT = EffectKind(
    name="joint_compliance",
    port=Port.GEAR,
    components=("joints", *MOTORS),
    parameters=(
        Parameter(
            "stiffness", "N m/rad", 1.0, 1e12, starts=(1e12,), reciprocal=True, typical=0.0003
        ),
    ),
    operate=_operate,
    says=lambda component, v: (
        f"{'all joints yield' if component.endswith('joints') else component + ' yields'} under "
        f"load, with a stiffness of {v['stiffness']:.4g} N m/rad"
    ),
    order=5,
    nothing=float("inf"),
    # inertia beside weight, damping beside the spring; inertia on a spring rings
    discrepancy=Discrepancy(0.012, 0.012, leads_to={"resonance": 1.0}),
)

CARD = EffectCard(
    name=EFFECT.name,
    kind=EFFECT,
    listed=5,
    on={"command": EFFECT},
    says={
        "": "the axis yields under load, with a stiffness of {stiffness}",
    },
    log_odds={
        # wears or is set by hand
        "command/droop": -1.0,
        "pose/droop": -1.0,
    },
    words=Words(
        noun="shafts of {part} that yield under load",
        axis="parts of {part} that yield under load",
        further="further yielding of {part} under load",
        regime="where the load on the joints is high",
        axis_regime="where the load is high",
    ),
    remedies={
        "": "look for loose clamps and thin shafts at {part}: it yields under load",
        "chain/": (
            "look for what gives way between encoder and link of {part}: it yields under weight; "
            "where that is its gear, enter the stiffness in the robot file"
        ),
        "servo_axis/": (
            "raise the gain of the position control of {part}, or look for what gives way: it "
            "yields under load"
        ),
        "slide/": (
            "tension the belt of {part}, look for a loose coupling or screw bearing; where a servo "
            "drives it, raise its gain: it yields under load"
        ),
    },
    drawing=Drawing(motor="gear", axis=("shaft",)),
    traits=frozenset({Trait.BEHIND_READING, Trait.UNDER_LOAD}),
    rule=Rule.SERIES,
    compensated=Compensated.INVERSE,
    confusions=(
        Confusion(
            "home_offset",
            stands_in={
                # against a zero set by hand, which every axis has
                "loaded/offset": StandIn(-0.7),
            },
            axis=(
                "{say_what_pulls}repeat the motion with a known weight on the axis: a yielding "
                "joint sags further"
            ),
        ),
        Confusion(
            "upper_arm_length",
            by_hand=(
                "hang 0.5 kg on the platform and read the sensors again: yielding joints sag "
                "further, wrong lengths do not"
            ),
            effort=2,
        ),
        Confusion(
            "payload",
            by_hand="weigh the platform with all it carries",
            effort=3,
        ),
    ),
    fit=Fit(
        coordinates=(Coordinate("stiffness", "reciprocal", step=1e-4, low=0.0, high=1.0),),
        shapes=(Shape((0.0,), (0,), 1e-4),),
    ),
)
