"""All readings are late by the same time."""

from __future__ import annotations

from deltactl.models.effects.card import (
    ByHand,
    Compensated,
    Coordinate,
    Drawing,
    EffectCard,
    Equal,
    Fit,
    Rule,
    Search,
    Shape,
    Trait,
    Words,
)
from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import (
    Discrepancy,
    EffectKind,
    Memory,
    Parameter,
    Port,
    Values,
    scalar,
)
from deltactl.models.signals import delayed


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    late_s = scalar(values, "time")
    flow.ranges_m = delayed(flow.ranges_m, flow.t_s, flow.stretch_start_s, late_s, memory)


EFFECT = EffectKind(
    name="sensor_latency",
    port=Port.CLOCK,
    components=("sensors",),
    parameters=(Parameter("time", "s", 0.0, 2.0, step=1e-3, typical=0.05),),
    operate=_operate,
    says=lambda component, v: f"all readings are {1e3 * v['time']:.1f} ms late",
    # filters inside the sensor
    discrepancy=Discrepancy(0.001, 0.003),
)


def _on_axis(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    flow.measured_rad = flow.behind(flow.measured_rad, scalar(values, "time"), 0.0, memory)


ON_AXIS = EffectKind(
    name="sensor_latency",
    port=Port.ENCODER,
    components=("axis",),
    parameters=(Parameter("time", "s", 0.0, 2.0, step=1e-3),),
    operate=_on_axis,
    says=lambda component, v: f"the readings are {1e3 * v['time']:.1f} ms late",
    order=1,
)

CARD = EffectCard(
    name=EFFECT.name,
    kind=EFFECT,
    listed=0,
    on={"command": ON_AXIS, "range": ON_AXIS},
    says={
        "": "the readings are late by {time}",
    },
    log_odds={
        # ranging takes tens of milliseconds, and few stamps allow for it
        "range/late": -1.5,
        # arms swing for a second after a move, and people wait for it
        "pose/rest": -3.0,
    },
    words=Words(
        noun="readings that come late",
        regime="while the platform moves, on all sensors",
        axis_regime="in motion",
        sizes={"time": "late by"},
    ),
    remedies={
        "chain/": "wait longer before a pose is read: {size} of the last move is yet to come",
        "": "allow for readings that come {size} late, or read them faster",
        "axis/": "take {size} off the times of the readings, or read them faster",
        "sensor/": "take {size} off the times of the readings, or read them faster",
    },
    drawing=Drawing(axis=("encoder",)),
    traits=frozenset({Trait.DELAY, Trait.READING}),
    rule=Rule.SUM,
    compensated=Compensated.IN_READINGS,
    by_hand=ByHand("record the arm angles (theta_1 to theta_3)", 7),
    fit=Fit(
        coordinates=(Coordinate("time", step=2e-3, low=0.0, high=2.0),),
        shapes=tuple(Shape((0.0,), (0,), reach) for reach in (0.02, 0.1, 0.2)),
        searched=Search.CLOCK,
    ),
    equals=(
        # unless the joints are seen
        Equal("following_lag", lambda late, _: [{"time": 0.0, "dead_time": late["time"]}], True),
    ),
)
