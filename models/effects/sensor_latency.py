"""All readings are late by the same time."""

from __future__ import annotations

from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import Discrepancy, EffectKind, Memory, Parameter, Values, scalar
from deltactl.models.effects.port import Port
from deltactl.models.recursion import delayed


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    late_s = scalar(values, "time")
    flow.ranges_m = delayed(flow.ranges_m, flow.t_s, flow.stretch_start_s, late_s, memory)


EFFECT = EffectKind(
    name="sensor_latency",
    port=Port.CLOCK,
    components=("sensors",),
    parameters=(Parameter("time", "s", 0.0, 2.0, step=1e-3, typical=0.05),),
    operate=_operate,
    says=lambda component, v: f"all readings are {1e3 * v['time']:.1f} ms late",
    # filters inside the sensor
    discrepancy=Discrepancy(0.001, 0.003),
)
