"""A distance sensor repeats an old value for a while."""

from __future__ import annotations

import numpy as np

from deltactl.models.effects.card import Coordinate, Drawing, EffectCard, Fit, Search, Trait, Words
from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import RANGES, EffectKind, Memory, Parameter, Port, Values, scalar


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    start_s = scalar(values, "time")
    held = (flow.t_s >= start_s) & (flow.t_s < start_s + scalar(values, "duration"))
    if held.any() and "value" not in memory:
        memory["value"] = flow.ranges_m[int(np.argmax(held)), index]
    if held.any():
        flow.ranges_m[held, index] = memory["value"]


EFFECT = EffectKind(
    name="stale_reading",
    port=Port.CLOCK,
    components=RANGES,
    parameters=(
        Parameter("duration", "s", 0.0, 1e6, step=0.05),
        Parameter("time", "s", -1e9, 1e9, step=0.05),
    ),
    operate=_operate,
    says=lambda component, v: (
        f"{component} repeats an old value from {v['time']:.2f} s on for {v['duration']:.2f} s"
    ),
    order=1,
    smooth=False,
    event=True,
)

CARD = EffectCard(
    name=EFFECT.name,
    kind=EFFECT,
    listed=1,
    words=Words(
        noun="old values repeated by {part}",
        regime="in one stretch of time",
        sizes={"time": "at", "times_s": "at"},
    ),
    remedies={
        "": "look at the cable and supply of {part}: it repeats old values",
    },
    drawing=Drawing(axis=("sensor",)),
    traits=frozenset({Trait.READING}),
    left="happened once: look at the sensor and its cable",
    fit=Fit(
        coordinates=(Coordinate("duration", "frozen"), Coordinate("time", "frozen")),
        searched=Search.REPEATS,
    ),
)
