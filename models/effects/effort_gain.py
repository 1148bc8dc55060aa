"""The drive gives another force per unit of effort than the robot file says."""

from __future__ import annotations

from deltactl.models.effects.card import Drawing, EffectCard, Trait, Words
from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import EffectKind, Memory, Parameter, Port, Values, scalar


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    flow.angles_rad *= scalar(values, "scale")


EFFECT = EffectKind(
    name="effort_gain",
    port=Port.MOTOR,
    components=("axis",),
    parameters=(Parameter("scale", "1", 0.02, 50.0, step=1e-3),),
    operate=_operate,
    says=lambda component, v: (
        f"the drive gives {v['scale']:.4g} times the force that the robot file says"
    ),
    order=1,
    nothing=1.0,
)

CARD = EffectCard(
    name="effort_gain",
    on={"effort": EFFECT},
    says={
        "": "the drive gives {scale} times the force that the robot file says",
    },
    log_odds={
        # printed on the motor, and measured by its maker
        "effort/gain": -3.0,
        # drives are calibrated where they are made
        "joint": -3.0,
    },
    words=Words(
        noun="a wrong scale between effort and force or torque of {part}",
        axis_regime="wherever there is effort",
    ),
    remedies={
        "": (
            "set the scale between effort and force of {part}, if its effort is in the unit of the "
            "robot file: it gives {size} {sign:more|less} than the file says"
        ),
    },
    drawing=Drawing(axis=("motor",)),
    traits=frozenset({Trait.SIGNED, Trait.SCALES_FORCES}),
)
