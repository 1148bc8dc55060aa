"""A ranging sensor reports a constant too much."""

from __future__ import annotations

from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import RANGES, EffectKind, Memory, Parameter, Values, scalar
from deltactl.models.effects.port import Port


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    flow.ranges_m[:, index] += scalar(values, "offset")


EFFECT = EffectKind(
    name="sensor_offset",
    port=Port.SENSOR,
    components=RANGES,
    parameters=(Parameter("offset", "m", -0.5, 0.5, typical=0.005),),
    operate=_operate,
    says=lambda component, v: f"{component} reads {1e3 * v['offset']:+.2f} mm off, everywhere",
    order=2,
    pose_alone=True,
)
