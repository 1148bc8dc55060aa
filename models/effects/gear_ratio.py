"""The gear turns the arm by another amount per commanded angle than believed."""

from __future__ import annotations

from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import MOTORS, EffectKind, Memory, Parameter, Values, scalar
from deltactl.models.effects.port import Port


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    flow.angles_rad[:, index] *= scalar(values, "scale")


EFFECT = EffectKind(
    name="gear_ratio",
    port=Port.GEAR,
    components=MOTORS,
    parameters=(Parameter("scale", "1", 0.2, 5.0, starts=(1.0,), typical=0.005),),
    operate=_operate,
    says=lambda component, v: (
        f"the drive of {component} turns the arm {100 * (v['scale'] - 1):+.2f} % "
        "per commanded angle against the robot file"
    ),
    nothing=1.0,
    pose_alone=True,
)
