"""The arm stands at another angle than believed when the count is 0."""

from __future__ import annotations

import numpy as np

from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import MOTORS, EffectKind, Memory, Parameter, Values, scalar
from deltactl.models.effects.port import Port


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    flow.angles_rad[:, index] += scalar(values, "angle")


EFFECT = EffectKind(
    name="home_offset",
    port=Port.ARM,
    components=MOTORS,
    parameters=(Parameter("angle", "rad", -0.6, 0.6, typical=0.01),),
    operate=_operate,
    says=lambda component, v: (
        f"at home the arm of {component} stands {abs(np.degrees(v['angle'])):.3f} degrees"
        f" {'lower' if v['angle'] > 0.0 else 'higher'} than it should"
    ),
    pose_alone=True,
)
