"""Something under the platform stops it: it cannot go below a height.

The arms press it on and give way like springs. A smooth stop lets it slide where they send it; a
rough one holds it where it touched down until they pull sideways by more than `grip` times how
far they press it in. That is Coulomb's law for springs that are equally stiff in all directions,
which those of a delta are within a factor of two.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from deltactl.models.effects.card import Coordinate, EffectCard, Fit, Search, Shape, Trait, Words
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

IntArray = np.ndarray[Any, np.dtype[np.signedinteger[Any]]]


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    height_m, grip = scalar(values, "height"), scalar(values, "grip")
    if grip > 0.0:
        _hold(flow, height_m, grip, memory)
    flow.position_m[:, 2] = np.maximum(flow.position_m[:, 2], height_m)


def _hold(flow: Flow, height_m: float, grip: float, memory: Memory) -> None:
    """Drag the platform behind where the arms send it, while it is pressed down."""
    sent_m = flow.position_m
    pressed_m = height_m - sent_m[:, 2]
    down = np.flatnonzero(pressed_m > 0.0)
    goes_on = np.diff(down, prepend=-2) == 1
    goes_on &= ~flow.fresh[down]
    touched_m = _touched(sent_m, pressed_m, flow.fresh, down)
    held: tuple[float, float] | None = memory.pop("held_m", None)
    if len(down) and down[0] == 0 and not flow.fresh[0]:
        goes_on[0] = held is not None
    x, y = held or (0.0, 0.0)
    path: list[tuple[float, float]] = []
    for on, start, sent, room in zip(
        goes_on.tolist(),
        touched_m.tolist(),
        sent_m[down, :2].tolist(),
        (grip * pressed_m[down]).tolist(),
        strict=True,
    ):
        if not on:
            x, y = start
        east, north = sent[0] - x, sent[1] - y
        pulled = (east * east + north * north) ** 0.5
        if pulled > room:
            x, y = sent[0] - east * room / pulled, sent[1] - north * room / pulled
        path.append((x, y))
    if path:
        sent_m[down, :2] = path
        if down[-1] == len(sent_m) - 1:
            memory["held_m"] = path[-1]


def _touched(
    sent_m: FloatArray, pressed_m: FloatArray, fresh: BoolArray, down: IntArray
) -> FloatArray:
    """Where the platform touched down, were each sample in `down` its first; (len(down), 2)."""
    before = np.maximum(down - 1, 0)
    fell = pressed_m[down] - pressed_m[before]
    share = np.where(
        (pressed_m[before] <= 0.0) & ~fresh[down] & (fell > 0.0),
        pressed_m[down] / np.where(fell > 0.0, fell, 1.0),
        0.0,
    )
    way = sent_m[down, :2] - sent_m[before, :2]
    touched: FloatArray = sent_m[down, :2] - share[:, None] * way
    return touched


EFFECT = EffectKind(
    name="contact",
    port=Port.PLATFORM,
    components=("platform",),
    parameters=(
        Parameter("height", "m", -5.0, 5.0, step=5e-4, spread=0.1),
        Parameter("grip", "1", 0.0, 100.0, step=0.05, default=0.0, spread=3),
    ),
    operate=_operate,
    says=lambda component, v: (
        f"something stops the platform at a height of {1e3 * v['height']:.1f} mm"
        + (", and holds it sideways where it touches" if v.get("grip", 0.0) > 0.2 else "")
    ),
    order=1,
    smooth=False,
    nothing=float("-inf"),
    # A platform that slips and sticks where it is pressed on; arms that press on a stop yield, and
    # stop and pad give way by a quarter of a millimetre.
    discrepancy=Discrepancy(
        0.002,
        0.002,
        leads_to={"joint_compliance": 0.01, "payload": 0.01, "resonance": 0.01},
        gives_way={"height": 2.5e-4},
    ),
    local=True,
)

CARD = EffectCard(
    name=EFFECT.name,
    kind=EFFECT,
    listed=0,
    words=Words(
        noun="something in the way of {part}",
        regime="in the lowest part of the workspace",
    ),
    remedies={
        "": "clear away what stops the platform at {size}",
    },
    traits=frozenset({Trait.IN_THE_WAY}),
    left="something is in the way: look at the table, or raise the path",
    fit=Fit(
        coordinates=(
            Coordinate("height", step=5e-4),
            Coordinate("grip", step=0.05, low=0.0, high=20.0),
        ),
        # Shares of the heights that the platform was sent to; a smooth stop, and rubber on steel.
        shapes=tuple(
            Shape((share, grip), ())
            for share in (0.02, 0.05, 0.1, 0.2, 0.35)
            for grip in (0.0, 1.5)
        ),
        searched=Search.HEIGHTS,
    ),
)
