"""The gear adds an error that repeats with the angle at its output."""

from __future__ import annotations

import numpy as np

from models.effects.flow import Flow
from models.effects.kind import MOTORS, EffectKind, Memory, Parameter, Values, scalar
from models.effects.port import Port


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    angle = flow.angles_rad[:, index]
    turns = 2.0 * np.pi * angle / scalar(values, "period")
    flow.angles_rad[:, index] = angle + scalar(values, "amplitude") * np.sin(
        turns + scalar(values, "phase")
    )


EFFECT = EffectKind(
    name="transmission_error",
    port=Port.GEAR,
    components=MOTORS,
    parameters=(
        Parameter("amplitude", "rad", 0.0, 0.2, starts=(0.001,)),
        Parameter("period", "rad", 1e-3, 2.0 * np.pi, starts=(2.0 * np.pi,), step=1e-4),
        Parameter("phase", "rad", -np.pi, np.pi, starts=(0.0,), default=0.0),
    ),
    operate=_operate,
    says=lambda component, v: (
        f"the gear of {component} has a periodic error of {1e3 * v['amplitude']:.2f} mrad "
        f"every {np.degrees(v['period']):.2f} degrees"
    ),
    order=1,
)
