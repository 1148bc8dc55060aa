"""Play of a single axis: backlash of the gear, and friction behind a compliant shaft.

As positions show them they are one operator (reference sheet of the diagnosis): the axis stays
until the drive has crossed the width. A known load that pulls holds loose teeth on one flank; it
does nothing to friction. `start` says where in the play the axis stood at first, -1..1; `unloaded`
which share of the friction is there without a load: bearings and teeth rub by what they carry.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from deltactl.models.effects.flow import BoolArray, Flow
from deltactl.models.effects.kind import (
    Discrepancy,
    EffectKind,
    Memory,
    Parameter,
    Port,
    Values,
    scalar,
)
from deltactl.models.robot import FloatArray
from deltactl.models.signals import clipped

LEAST_PULL = 0.1
"""Share of the largest load below which bearings hold the axis where it is within the play."""


def loose(
    driven: FloatArray,
    fresh: BoolArray,
    width: float | FloatArray,
    starts: FloatArray,
    pull: FloatArray,
    before: float,
) -> FloatArray:
    """The axis behind play of a width, all (n,); `before` is where it stood before the first.

    width: one, or (n,) where friction grows with the load that the bearings and teeth carry.
    starts: where in the play each stretch begins, -1..1; (number of stretches,).
    """
    half = 0.5 * width
    low, high = driven - half, driven + half
    most = float(np.abs(pull).max(initial=0.0))
    if most == 0.0 and isinstance(half, float):
        return _between_turns(driven, fresh, half, starts, before)
    side = np.where(np.abs(pull) > LEAST_PULL * most, np.sign(pull), 0.0)
    begin = np.where(side[fresh] != 0.0, side[fresh], starts)
    low[fresh] = high[fresh] = driven[fresh] + (half * np.ones(len(driven)))[fresh] * begin
    return clipped(2.0 * half * side, low, high, before)


def _between_turns(
    driven: FloatArray, fresh: BoolArray, half: float, starts: FloatArray, before: float
) -> FloatArray:
    """The same with no load: from one turning point of the drive to the next in one go."""
    steps = np.sign(np.diff(driven))
    moving = np.flatnonzero(steps)
    turns = moving[1:][np.diff(steps[moving]) != 0.0] + 1
    begins = dict(zip(np.flatnonzero(fresh).tolist(), starts.tolist(), strict=True))
    edges = np.unique(np.concatenate([[0], turns, [*begins], [len(driven)]]))
    axis, at = np.empty_like(driven), before
    for first, end in pairwise(edges.astype(int).tolist()):
        part = driven[first:end]
        if first in begins:
            at = float(part[0] + half * begins[first])
        falling = part[-1] < (driven[first - 1] if first and first not in begins else part[0])
        axis[first:end] = np.minimum(at, part + half) if falling else np.maximum(at, part - half)
        at = float(axis[end - 1])
    return axis


def _play(
    flow: Flow, values: Values, memory: Memory, width: float | FloatArray, pull: FloatArray
) -> None:
    driven = flow.angles_rad[:, 0]
    before = float(memory.get("arm", driven[0]))
    start = scalar(values, "start")
    starts = np.full(int(np.count_nonzero(flow.fresh)), start)
    arm = loose(driven, flow.fresh, width, starts, pull, before)
    memory["arm"] = arm[-1]
    flow.angles_rad[:, 0] = arm


def _loose(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    _play(flow, values, memory, scalar(values, "width"), flow.load.torque_nm[:, 0])


def _rubbing(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    width: float | FloatArray = scalar(values, "width")
    share, load = scalar(values, "unloaded"), np.abs(flow.load.torque_nm[:, 0])
    if share < 1.0 and load.any():
        width = width * (share + (1.0 - share) * load / load.mean())
    _play(flow, values, memory, width, np.zeros(len(flow.t_s)))


def _kind(
    name: str,
    operate: Callable[[Flow, int, Values, Memory], None],
    text: str,
    more: tuple[Parameter, ...] = (),
) -> EffectKind:
    return EffectKind(
        name=name,
        port=Port.GEAR,
        components=("axis",),
        parameters=(
            Parameter("width", "rad", 0.0, 1.0, step=1e-4),
            Parameter("start", "1", -1.0, 1.0, step=0.02, default=0.0),
            *more,
        ),
        operate=operate,
        says=lambda component, v: text.format(1e3 * v["width"]),
        order=3,
        smooth=False,
        # a tooth or a bearing is not as square as its operator (as `gear_backlash` of a delta)
        discrepancy=Discrepancy(0.001, 0.012),
    )


BACKLASH = _kind("gear_backlash", _loose, "between drive and axis there is backlash of {:.4g} mrad")
FRICTION = _kind(
    "joint_friction",
    _rubbing,
    "friction holds the axis back by {:.4g} mrad in all between its two directions",
    (Parameter("unloaded", "1", 0.0, 1.0, step=0.02, default=1.0),),
)
