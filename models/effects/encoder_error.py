"""The angle encoder itself adds an error that repeats with the angle."""

from __future__ import annotations

from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import MOTORS, EffectKind, Memory, Values
from deltactl.models.effects.periodic import PARAMETERS, add_periodic, size_in_words
from deltactl.models.effects.port import Port


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    add_periodic(flow.measured_rad, index, values)


EFFECT = EffectKind(
    name="encoder_error",
    port=Port.ENCODER,
    components=MOTORS,
    parameters=PARAMETERS,
    operate=_operate,
    says=lambda component, v: (
        f"the angle encoder of {component} has a periodic error of {size_in_words(v)}"
    ),
    order=0,
)
