"""What can be wrong with the torques of a servo delta: effects of the vocabulary, joint by joint.

Sizes are at the arm's shaft and beyond what the robot file says: a friction of 0.001 N m is that
much more than the file's own.
"""

from __future__ import annotations

import numpy as np

from deltactl.models.effects.card import EffectCard, Words
from deltactl.models.effects.flow import Flow, TorqueFlow, torque_flow
from deltactl.models.effects.kind import (
    MOTORS,
    EffectKind,
    Memory,
    Operate,
    Parameter,
    Port,
    Values,
    adds,
    scalar,
)
from deltactl.models.robot import FloatArray


def _adds(parameter: str, column: str) -> Operate:
    """An effect that adds its size times a column of the flow to one joint's torque."""

    def operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
        flow = torque_flow(flow)
        flow.angles_rad[:, index] += scalar(values, parameter) * _of(flow, column)[:, index]

    return operate


def _of(flow: TorqueFlow, column: str) -> FloatArray:
    values: FloatArray = getattr(flow, column)
    return values


def _weigh(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    flow = torque_flow(flow)
    level = np.cos(flow.turned_rad[:, index])
    flow.angles_rad[:, index] -= scalar(values, "torque") * level


def _inertia(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    flow = torque_flow(flow)
    more = scalar(values, "inertia") - flow.rotor_kgm2
    flow.angles_rad[:, index] += more * flow.acceleration_radps2[:, index]


def _payload(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    flow = torque_flow(flow)
    flow.angles_rad += scalar(values, "mass") * flow.per_kg_nm


def _gain(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    flow.angles_rad[:, index] /= scalar(values, "scale")


_TORQUE = 100.0
FRICTION = EffectKind(
    name="joint_friction",
    port=Port.GEAR,
    components=MOTORS,
    parameters=(Parameter("torque", "N m", -_TORQUE, _TORQUE),),
    operate=_adds("torque", "direction"),
    says=lambda component, v: (
        f"dry (Coulomb) friction brakes {component} by {1e3 * v['torque']:.3g} mN m at the arm "
        "more than the robot file says"
    ),
)
VISCOUS = EffectKind(
    name="viscous_friction",
    port=Port.GEAR,
    components=MOTORS,
    parameters=(Parameter("coefficient", "N m s/rad", -_TORQUE, _TORQUE),),
    operate=_adds("coefficient", "speed_radps"),
    says=lambda component, v: (
        f"friction that grows with speed brakes {component} by {1e3 * v['coefficient']:.3g} "
        "mN m s/rad at the arm more than the robot file says"
    ),
)
GRAVITY = EffectKind(
    name="gravity_error",
    port=Port.ARM,
    components=MOTORS,
    parameters=(Parameter("torque", "N m", -_TORQUE, _TORQUE),),
    operate=_weigh,
    says=lambda component, v: (
        f"{component}'s arm is pulled down by {1e3 * v['torque']:+.3g} mN m at angle 0 (by the "
        "cosine at others) beyond the masses of the robot file"
    ),
)
INERTIA = EffectKind(
    name="inertia",
    port=Port.ARM,
    components=MOTORS,
    parameters=(Parameter("inertia", "kg m2", 0.0, _TORQUE),),
    operate=_inertia,
    says=lambda component, v: (
        f"rotor and gear of {component} have {v['inertia']:.3g} kg m2, seen at the arm"
    ),
)
PAYLOAD = EffectKind(
    name="payload",
    port=Port.PLATFORM,
    components=("platform",),
    parameters=(Parameter("mass", "kg", -10.0, 50.0),),
    operate=_payload,
    says=lambda component, v: (
        f"the platform carries {1e3 * v['mass']:.3g} g more than the robot file says"
    ),
)
GAIN = EffectKind(
    name="effort_gain",
    port=Port.MOTOR,
    components=MOTORS,
    parameters=(Parameter("scale", "1", 0.02, 50.0),),
    operate=_gain,
    says=lambda component, v: (
        f"{component} gives {v['scale']:.4g} times the torque per ampere that the robot file says"
    ),
    order=1,
    nothing=1.0,
)
OFFSET = EffectKind(
    name="effort_offset",
    port=Port.MOTOR,
    components=MOTORS,
    parameters=(Parameter("offset", "N m", -_TORQUE, _TORQUE),),
    operate=adds("angles_rad", "offset"),
    says=lambda component, v: (
        f"a current that makes {1e3 * v['offset']:+.3g} mN m at the arm of {component} is there all"
        " the time, whichever way it moves: it holds against something, or the current's zero is"
        " off"
    ),
    order=2,
)
SERVO_EFFECTS = {
    kind.name: kind for kind in (FRICTION, VISCOUS, GRAVITY, INERTIA, PAYLOAD, GAIN, OFFSET)
}
CARDS = (
    EffectCard(
        name=GRAVITY.name,
        log_odds={"joint": -2.0},  # arms with cables and screws
        words=Words(axis_regime="everywhere, by the cosine of the arm's angle"),
    ),
)
