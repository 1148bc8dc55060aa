"""The effort holds a constant that moves nothing.

inertia * acceleration = effort - friction - offset, the sign in which identification papers give
it (Janot, Gautier and Brunot 2019, EMPS: equation 1).
"""

from __future__ import annotations

from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import EffectKind, Memory, Parameter, Values, scalar
from deltactl.models.effects.port import Port


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    flow.angles_rad -= scalar(values, "offset")


EFFECT = EffectKind(
    name="effort_offset",
    port=Port.MOTOR,
    components=("axis",),
    parameters=(Parameter("offset", "N m", -1e5, 1e5, step=1e-3),),
    operate=_operate,
    says=lambda component, v: f"{v['offset']:+.4g} N m of the effort move nothing",
    order=2,
)
