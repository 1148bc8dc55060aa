"""Friction in proportion to speed on an axis that is driven by effort."""

from __future__ import annotations

from deltactl.models.effects.effort_flow import effort_flow
from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import EffectKind, Memory, Parameter, Values, scalar
from deltactl.models.effects.port import Port


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    flow.angles_rad -= scalar(values, "coefficient") * effort_flow(flow).velocity


EFFECT = EffectKind(
    name="viscous_friction",
    port=Port.GEAR,
    components=("axis",),
    parameters=(Parameter("coefficient", "N m s/rad", 0.0, 1e6, step=1e-3),),
    operate=_operate,
    says=lambda component, v: (
        f"friction of {v['coefficient']:.4g} N m s/rad grows with the speed of the axis"
    ),
    order=2,
)
