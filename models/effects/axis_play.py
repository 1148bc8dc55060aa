"""Play of a single axis: backlash of the gear, and friction behind a compliant shaft.

As positions show them they are one operator (reference sheet of the diagnosis): the axis stays
until the drive has crossed the width. A known load that pulls holds loose teeth on one flank; it
does nothing to friction. `start` says where in the play the axis stood at first, -1..1; `unloaded`
which share of the friction is there without a load: bearings and teeth rub by what they carry.
`build_up`: contacts yield before they slide, so that the friction of a servo builds up over a way,
in widths. Friction that grows with a load builds up at once.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

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
SUDDEN = 1e-3
"""Share of the width below which friction builds up at once."""
TO_GO = np.concatenate([np.linspace(1.0, 0.02, 600), np.geomspace(0.02, 1e-14, 300)[1:]])
"""Half the share of the friction that is still to build up: what the way to it is tabulated by."""


def loose(
    driven: FloatArray,
    fresh: BoolArray,
    width: float | FloatArray,
    starts: FloatArray,
    pull: FloatArray,
    before: tuple[float, float],
    build_up: float = 0.0,
) -> FloatArray:
    """The axis behind play of a width, all (n,); `before`: where drive and axis stood before that.

    width: one, or (n,) where friction grows with the load that the bearings and teeth carry.
    starts: where in the play each stretch begins, -1..1; (number of stretches,).
    build_up: of friction of one width: the way over which it builds up, in widths.
    """
    half = 0.5 * width
    low, high = driven - half, driven + half
    most = float(np.abs(pull).max(initial=0.0))
    if most == 0.0 and isinstance(half, float):
        return _between_turns(driven, fresh, half, starts, before, build_up)
    side = np.where(np.abs(pull) > LEAST_PULL * most, np.sign(pull), 0.0)
    begin = np.where(side[fresh] != 0.0, side[fresh], starts)
    low[fresh] = high[fresh] = driven[fresh] + (half * np.ones(len(driven)))[fresh] * begin
    return clipped(2.0 * half * side, low, high, before[1])


def _between_turns(
    driven: FloatArray,
    fresh: BoolArray,
    half: float,
    starts: FloatArray,
    before: tuple[float, float],
    build_up: float,
) -> FloatArray:
    """The same with no load: from one turning point of the drive to the next in one go."""
    if half <= 0.0:
        return driven.copy()
    steps = np.sign(np.diff(driven))
    moving = np.flatnonzero(steps)
    turns = moving[1:][np.diff(steps[moving]) != 0.0] + 1
    begins = dict(zip(np.flatnonzero(fresh).tolist(), starts.tolist(), strict=True))
    edges = np.unique(np.concatenate([[0], turns, [*begins], [len(driven)]])).astype(int)
    slides = _AtOnce(half) if build_up <= SUDDEN else _BuildingUp(half, build_up)
    (drive, at), begun = before, []
    for first, end in pairwise(edges.tolist()):
        if first in begins:
            drive = float(driven[first])
            at = drive + half * begins[first]
        last = float(driven[end - 1])
        way = -1.0 if last < drive else 1.0
        begun.append((way, way * drive, slides.begin(way * drive, way * at)))
        drive, at = last, way * float(slides.go_on(way * last, *begun[-1][1:]))
    ways, drives, began = np.repeat(np.array(begun), np.diff(edges), axis=0).T
    behind: FloatArray = ways * slides.go_on(ways * driven, drives, began)
    return behind


@dataclass(frozen=True)
class _AtOnce:
    """Play, or friction that is there at once: the axis stays until the drive has come to it."""

    half: float

    def begin(self, drive: float, at: float) -> float:
        """What is kept of a turning point: where the axis is."""
        return at

    def go_on(self, driven: Any, drive: Any, at: Any) -> Any:
        """The axis behind a drive that goes forward."""
        return np.maximum(at, driven - self.half)


class _BuildingUp:
    """Friction that grows with the axis' way towards its final size, while a spring winds up to it
    (Dahl 1968, A Solid Friction Model).
    """

    def __init__(self, half: float, build_up: float) -> None:
        self._half, self._build_up = half, build_up
        self._ways = 1.0 - TO_GO - build_up * np.log(TO_GO)

    def begin(self, drive: float, at: float) -> float:
        """Way of the drive, in widths, from full friction against it to a turning point."""
        to_go = min(max(0.5 * (1.0 + (at - drive) / self._half), float(TO_GO[-1])), 1.0)
        return 1.0 - to_go - self._build_up * math.log(to_go)

    def go_on(self, driven: Any, drive: Any, begun: Any) -> Any:
        """The axis behind a drive that goes forward."""
        way = begun + 0.5 * (driven - drive) / self._half
        return driven - self._half * (1.0 - 2.0 * np.interp(way, self._ways, TO_GO))


def _play(
    flow: Flow,
    values: Values,
    memory: Memory,
    width: float | FloatArray,
    pull: FloatArray,
    build_up: float = 0.0,
) -> None:
    driven = flow.angles_rad[:, 0].copy()
    before = float(memory.get("drive", driven[0])), float(memory.get("arm", driven[0]))
    start = scalar(values, "start")
    starts = np.full(int(np.count_nonzero(flow.fresh)), start)
    arm = loose(driven, flow.fresh, width, starts, pull, before, build_up)
    memory["drive"], memory["arm"] = driven[-1], arm[-1]
    flow.angles_rad[:, 0] = arm


def _loose(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    _play(flow, values, memory, scalar(values, "width"), flow.load.torque_nm[:, 0])


def _rubbing(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    width: float | FloatArray = scalar(values, "width")
    share, load = scalar(values, "unloaded"), np.abs(flow.load.torque_nm[:, 0])
    if share < 1.0 and load.any():
        width = width * (share + (1.0 - share) * load / load.mean())
    build_up = scalar(values, "build_up")
    _play(flow, values, memory, width, np.zeros(len(flow.t_s)), build_up)


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
    (
        Parameter("unloaded", "1", 0.0, 1.0, step=0.02, default=1.0),
        Parameter("build_up", "1", 0.0, 1.0, step=0.01, default=0.0),
    ),
)
