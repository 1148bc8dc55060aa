"""Dry friction of a constant size, `joint_friction` of an axis that is driven by effort.

torque (1 + asymmetry) in positive motion and torque (1 - asymmetry) in negative; at rest it holds.
"""

from __future__ import annotations

from deltactl.models.effects.effort_flow import effort_flow, rub
from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import EffectKind, Memory, Parameter, Values, scalar
from deltactl.models.effects.port import Port


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    flow = effort_flow(flow)
    torque, asymmetry = scalar(values, "torque"), scalar(values, "asymmetry")
    rub(flow, torque * (flow.direction + asymmetry), torque)


EFFECT = EffectKind(
    name="joint_friction",
    port=Port.GEAR,
    components=("axis",),
    parameters=(
        Parameter("torque", "N m", 0.0, 1e5, step=1e-3),
        Parameter("asymmetry", "1", -1.0, 1.0, step=0.01, default=0.0),
    ),
    operate=_operate,
    says=lambda component, v: f"dry (Coulomb) friction of {v['torque']:.4g} N m brakes the axis",
    order=3,
    smooth=False,
)
