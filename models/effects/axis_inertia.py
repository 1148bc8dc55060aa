"""The moving mass (or moment of inertia) is another than the robot file says."""

from __future__ import annotations

from deltactl.models.effects.card import Confusion, Drawing, EffectCard, Trait, Words
from deltactl.models.effects.flow import Flow, effort_flow
from deltactl.models.effects.kind import EffectKind, Memory, Parameter, Port, Values, scalar


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    effort_flow(flow).inertia = max(scalar(values, "inertia"), 1e-9)


EFFECT = EffectKind(
    name="inertia",
    port=Port.ARM,
    components=("axis",),
    parameters=(Parameter("inertia", "kg m2", 1e-9, 1e6, step=1e-4),),
    operate=_operate,
    says=lambda component, v: f"the axis moves {v['inertia']:.4g} kg m2",
)

CARD = EffectCard(
    name="inertia",
    on={"effort": EFFECT},
    says={
        "": "the moment of inertia of what the axis turns is {inertia}",
        "slide": "the axis moves a mass of {inertia}",
    },
    log_odds={
        # the file's is computed from drawings, but that of a whole machine is mostly near
        "effort/inertia": -2.0,
        # by exchange of a motor or an arm
        "joint": -2.5,
        # of a joint whose model has none: a URDF has no place for a rotor, and behind a gear of 100
        # it is as large as the arm
        "unstated": 1.0,
    },
    words=Words(
        noun="a wrong inertia of {part}",
        axis_regime="while the axis speeds up or slows down",
        sizes={"inertia": "true inertia"},
    ),
    remedies={
        "": "enter the true inertia of {part} in the robot file: {size}",
    },
    drawing=Drawing(axis=("load",)),
    traits=frozenset({Trait.ENTERED, Trait.SIGNED}),
    confusions=(
        Confusion(
            "effort_gain",
            axis=(
                "push the axis with a known force (a spring balance, a weight over a pulley) and "
                "record it as `load`"
            ),
        ),
    ),
)
