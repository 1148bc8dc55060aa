"""A lone axis rings after moves: the operator of `resonance`, on the axis itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from deltactl.models.effects import resonance
from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import Memory, Values
from deltactl.models.effects.port import Port


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    flow.position_m = np.repeat(flow.angles_rad[:, :1], 3, axis=1)
    resonance.EFFECT.operate(flow, index, values, memory)
    flow.angles_rad = flow.position_m[:, :1].copy()


EFFECT = replace(
    resonance.EFFECT,
    port=Port.ARM,
    components=("axis",),
    operate=_operate,
    says=lambda component, v: (
        f"the axis rings at {v['frequency']:.2f} Hz after moves, with a damping of "
        f"{v['damping']:.2f}"
    ),
    order=5,
)
