"""A load on the platform bears the joints down; how far depends on their stiffness."""

from __future__ import annotations

from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import Discrepancy, EffectKind, Memory, Parameter, Values, scalar
from deltactl.models.effects.port import Port


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    yields = scalar(values, "mass") / scalar(values, "stiffness")
    flow.angles_rad += flow.load.per_kg_nm * yields


EFFECT = EffectKind(
    name="payload",
    port=Port.GEAR,
    components=("platform",),
    parameters=(
        Parameter("mass", "kg", -0.5, 50.0, step=0.05, typical=0.3),
        Parameter("stiffness", "N m/rad", 1.0, 1e12, starts=(500.0,), default=500.0),
    ),
    operate=_operate,
    says=lambda component, v: (
        f"the platform carries {v['mass']:.3g} kg more than believed "
        f"(if the joints have {v['stiffness']:.4g} N m/rad)"
    ),
    order=6,
    # acts through compliance; inertia on a spring rings
    discrepancy=Discrepancy(0.012, 0.012, leads_to={"resonance": 1.0}),
    # compliance does nearly the same, and is the commoner
    penalty=12.0,
)
