"""Something under the platform stops it: it cannot go below a height."""

from __future__ import annotations

import numpy as np

from models.effects.flow import Flow
from models.effects.kind import EffectKind, Memory, Parameter, Values, scalar
from models.effects.port import Port


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    flow.position_m[:, 2] = np.maximum(flow.position_m[:, 2], scalar(values, "height"))


EFFECT = EffectKind(
    name="contact",
    port=Port.PLATFORM,
    components=("platform",),
    parameters=(Parameter("height", "m", -5.0, 5.0, step=5e-4),),
    operate=_operate,
    says=lambda component, v: (
        f"something stops the platform at a height of {1e3 * v['height']:.1f} mm"
    ),
    order=1,
    smooth=False,
    nothing=float("-inf"),
)
