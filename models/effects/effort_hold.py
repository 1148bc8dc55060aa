"""How the effort goes on between two samples: held (share 1), or smooth (share 2).

A filter that takes samples as joined by straight lines damps a smooth signal by (omega T)^2 / 12;
a signal that is truly held is damped by half of that. Taking share / 24 of the second difference
off makes up for it. Never a finding: a recording does not say how it was sampled.
"""

from __future__ import annotations

from models.effects.flow import Flow
from models.effects.kind import EffectKind, Memory, Parameter, Values, scalar
from models.effects.port import Port
from models.effects.second_difference import second_difference


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    bend = second_difference(flow.angles_rad, flow.fresh)
    flow.angles_rad -= scalar(values, "share") / 24.0 * bend


EFFECT = EffectKind(
    name="effort_hold",
    port=Port.MOTOR,
    components=("axis",),
    parameters=(Parameter("share", "1", -4.0, 6.0, step=0.1),),
    operate=_operate,
    says=lambda component, v: "the effort is held between samples",
    order=-1,
)
