"""The position readings of a lone axis are late."""

from __future__ import annotations

from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import EffectKind, Memory, Parameter, Values, scalar
from deltactl.models.effects.port import Port


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    flow.measured_rad = flow.behind(flow.measured_rad, scalar(values, "time"), 0.0, memory)


EFFECT = EffectKind(
    name="sensor_latency",
    port=Port.ENCODER,
    components=("axis",),
    parameters=(Parameter("time", "s", 0.0, 2.0, step=1e-3),),
    operate=_operate,
    says=lambda component, v: f"the readings are {1e3 * v['time']:.1f} ms late",
    order=1,
)
