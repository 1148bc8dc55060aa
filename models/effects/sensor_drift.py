"""A distance sensor's reading drifts towards an offset, from the start of the recording."""

from __future__ import annotations

import numpy as np

from deltactl.models.effects.card import (
    Compensated,
    Coordinate,
    Drawing,
    EffectCard,
    Fit,
    Rule,
    Trait,
    Words,
)
from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import (
    RANGES,
    Discrepancy,
    EffectKind,
    Memory,
    Parameter,
    Port,
    Values,
    scalar,
)

STARTS_S = (20.0, 100.0, 500.0, 2500.0)
"""Time constants from which fits begin: a chip's to a housing's, five times apart,"""
OF_SPAN = 2.0
"""less than so many times the recording, for slower is a straight line;"""
ELSE = 0.3
"""in a recording too short for those, this share of it,"""
ALSO = 0.2
"""and always this one: a warming that the recording holds whole."""


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    share = -np.expm1(-flow.since_s / scalar(values, "time_constant"))
    flow.ranges_m[:, index] += scalar(values, "offset") * share


EFFECT = EffectKind(
    name="sensor_drift",
    port=Port.SENSOR,
    components=RANGES,
    parameters=(
        Parameter("offset", "m", -0.5, 0.5, typical=0.005),
        Parameter("time_constant", "s", 1.0, 1e5, starts=(15.0, 60.0, 200.0), step=2.0, spread=1),
    ),
    operate=_operate,
    says=lambda component, v: (
        f"{component} drifts by {1e3 * v['offset']:+.2f} mm with a time constant of "
        f"{v['time_constant']:.0f} s"
    ),
    order=3,
    smooth=False,
    # one time constant of several
    discrepancy=Discrepancy(0.001, 0.001),
)

CARD = EffectCard(
    name=EFFECT.name,
    kind=EFFECT,
    listed=3,
    on={"range": EFFECT},
    says={
        "": "the sensor drifts by {offset} with a time constant of {time_constant}",
    },
    log_odds={
        # seen in the first minutes, which few recordings hold
        "range/drift": -3.0,
    },
    words=Words(
        noun="a drift of {part}",
        several="drifts of {part}",
        regime="growing since the start of the recording",
        axis_regime="growing since the start of the recording",
        axis_part="the sensor",
    ),
    remedies={
        "": "let {part} warm up before use: it drifts by {size}",
    },
    drawing=Drawing(axis=("encoder",)),
    traits=frozenset({Trait.READING, Trait.WARMS}),
    rule=Rule.SUM,
    compensated=Compensated.IN_READINGS,
    fit=Fit(
        coordinates=(
            Coordinate("offset", step=1e-4, low=-0.5, high=0.5),
            Coordinate("time_constant", "log", step=0.05, low=0.0, high=np.log(1e5)),
        ),
    ),
)
