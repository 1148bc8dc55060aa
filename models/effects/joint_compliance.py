"""Shafts and arms yield under the gravity torque at the joint."""

from __future__ import annotations

from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import (
    MOTORS,
    Discrepancy,
    EffectKind,
    Memory,
    Parameter,
    Values,
    joints,
    scalar,
)
from deltactl.models.effects.port import Port


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    part = joints(index)
    torque = flow.load.torque_nm[:, part]
    if flow.late_s > 0.0:  # a drive gives way as it follows: by the same time constant
        torque = flow.behind(torque, 0.0, flow.late_s, memory)
    flow.angles_rad[:, part] += torque / scalar(values, "stiffness")


EFFECT = EffectKind(
    name="joint_compliance",
    port=Port.GEAR,
    components=("joints", *MOTORS),
    parameters=(
        Parameter(
            "stiffness", "N m/rad", 1.0, 1e12, starts=(1e12,), reciprocal=True, typical=0.0003
        ),
    ),
    operate=_operate,
    says=lambda component, v: (
        f"{'all joints yield' if component.endswith('joints') else component + ' yields'} under "
        f"load, with a stiffness of {v['stiffness']:.4g} N m/rad"
    ),
    order=5,
    nothing=float("inf"),
    # inertia beside weight, damping beside the spring; inertia on a spring rings
    discrepancy=Discrepancy(0.012, 0.012, leads_to={"resonance": 1.0}),
)
