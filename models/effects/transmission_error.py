"""The gear adds an error that repeats with the angle at its output."""

from __future__ import annotations

from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import MOTORS, Discrepancy, EffectKind, Memory, Values
from deltactl.models.effects.periodic import PARAMETERS, add_periodic, size_in_words
from deltactl.models.effects.port import Port


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    add_periodic(flow.angles_rad, index, values)


EFFECT = EffectKind(
    name="transmission_error",
    port=Port.GEAR,
    components=MOTORS,
    parameters=PARAMETERS,
    operate=_operate,
    says=lambda component, v: (
        f"the gear or coupling of {component} has a periodic error of {size_in_words(v)}"
    ),
    order=1,
    # one harmonic of several
    discrepancy=Discrepancy(0.001, 0.003),
)
