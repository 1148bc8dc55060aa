"""Play of a lone axis: free play of the gear, and friction behind a compliant shaft.

As positions show them they are one operator (reference sheet of the diagnosis): the axis stays
until the drive has crossed the width. A known load that pulls holds loose teeth on one flank; it
does nothing to friction. `start` says where in the play the axis stood at first, -1..1.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from models.effects.flow import Flow
from models.effects.kind import EffectKind, Memory, Parameter, Values, scalar
from models.effects.port import Port
from models.effects.recursion import clipped
from models.robot import FloatArray


def _play(flow: Flow, values: Values, memory: Memory, pull: FloatArray) -> None:
    driven = flow.angles_rad[:, 0]
    half = 0.5 * scalar(values, "width")
    low, high = driven - half, driven + half
    begin = np.where(pull != 0.0, np.sign(pull), scalar(values, "start"))
    low[flow.fresh] = high[flow.fresh] = (driven + half * begin)[flow.fresh]
    fall = 2.0 * half * np.sign(pull)
    before = float(memory.get("arm", driven[0]))
    arm = clipped(fall, low, high, before)
    memory["arm"] = arm[-1]
    flow.angles_rad[:, 0] = arm


def _loose(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    _play(flow, values, memory, flow.load.torque_nm[:, 0])


def _rubbing(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    _play(flow, values, memory, np.zeros(len(flow.t_s)))


def _kind(name: str, operate: Callable[[Flow, int, Values, Memory], None], text: str) -> EffectKind:
    return EffectKind(
        name=name,
        port=Port.GEAR,
        components=("axis",),
        parameters=(
            Parameter("width", "rad", 0.0, 1.0, step=1e-4),
            Parameter("start", "1", -1.0, 1.0, step=0.02, default=0.0),
        ),
        operate=operate,
        says=lambda component, v: text.format(1e3 * v["width"]),
        order=3,
        smooth=False,
    )


BACKLASH = _kind(
    "gear_backlash", _loose, "between drive and axis there is free play of {:.4g} mrad"
)
FRICTION = _kind(
    "joint_friction",
    _rubbing,
    "friction holds the axis back by {:.4g} mrad in all between its two directions",
)
