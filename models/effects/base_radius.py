"""Base minus platform radius differs from what is believed; only the difference can be seen."""

from __future__ import annotations

from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import EffectKind, Memory, Parameter, Values, scalar
from deltactl.models.effects.port import Port


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    flow.linkage["radius_m"] = flow.linkage["radius_m"] + scalar(values, "length_error")


EFFECT = EffectKind(
    name="base_radius",
    port=Port.LINKAGE,
    components=("frame",),
    parameters=(Parameter("length_error", "m", -0.3, 0.3, typical=0.002),),
    operate=_operate,
    says=lambda component, v: (
        f"base radius minus platform radius is {1e3 * v['length_error']:+.2f} mm off"
    ),
    pose_alone=True,
)
