"""The sensors' frame is turned against the robot's: they see the platform turned with it."""

from __future__ import annotations

import numpy as np

from deltactl.models.effects.card import (
    Compensated,
    Coordinate,
    Drawing,
    EffectCard,
    Fit,
    Rule,
    Shape,
    Trait,
    Words,
)
from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import EffectKind, Memory, Parameter, Port, Values
from deltactl.models.robot import FloatArray


def rotation(vector_rad: FloatArray) -> FloatArray:
    """Rotation matrix of a rotation vector (Rodrigues' formula); shape (3, 3)."""
    angle = float(np.linalg.norm(vector_rad))
    x, y, z = vector_rad / max(angle, 1e-300)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turned: FloatArray = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return turned


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    flow.position_m = flow.position_m @ rotation(np.asarray(values["rotation"])).T


EFFECT = EffectKind(
    name="frame_tilt",
    port=Port.PLATFORM,
    components=("frame",),
    parameters=(Parameter("rotation", "rad", -0.6, 0.6, size=3, typical=0.01),),
    operate=_operate,
    says=lambda component, v: (
        "the sensor frame is turned against the robot by "
        f"{', '.join(f'{np.degrees(a):+.3f}' for a in v['rotation'])} degrees about x, y, z"
    ),
    order=2,
    pose_alone=True,
)

CARD = EffectCard(
    name=EFFECT.name,
    kind=EFFECT,
    listed=2,
    words=Words(
        noun="sensors turned against the robot",
        regime="in proportion to the distance from the origin",
    ),
    remedies={
        "": (
            "align the sensors with the robot, or enter their rotation ({size}) in the robot file"
        ),
    },
    drawing=Drawing(everywhere=("sensor_x", "sensor_y", "sensor_z")),
    traits=frozenset({Trait.READING, Trait.ENTERED, Trait.WARMS}),
    rule=Rule.SUM,
    compensated=Compensated.IN_READINGS,
    fit=Fit(
        coordinates=tuple(Coordinate("rotation", step=1e-4, part=part) for part in range(3)),
        shapes=(Shape((0.0, 0.0, 0.0), (0, 1, 2), 1e-4),),
    ),
    build_spread=0.002,  # rad: 1 mm over half a metre, between sensors and base
)
