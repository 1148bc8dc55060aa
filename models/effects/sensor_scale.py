"""A ranging sensor reports a constant multiple of the distance."""

from __future__ import annotations

from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import RANGES, EffectKind, Memory, Parameter, Values, scalar
from deltactl.models.effects.port import Port


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    flow.ranges_m[:, index] *= scalar(values, "scale")


EFFECT = EffectKind(
    name="sensor_scale",
    port=Port.SENSOR,
    components=RANGES,
    parameters=(Parameter("scale", "1", 0.2, 5.0, starts=(1.0,), typical=0.005),),
    operate=_operate,
    says=lambda component, v: (
        f"{component} reads {100 * (v['scale'] - 1):+.2f} % of the distance too much"
    ),
    order=1,
    nothing=1.0,
    # where a motion tells neither from an offset, the offset is likelier
    penalty=0.5,
    pose_alone=True,
)
