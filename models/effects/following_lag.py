"""The drive follows late: a pure delay, then a first-order lag."""

from __future__ import annotations

from deltactl.models.effects.card import (
    ByHand,
    Compensated,
    Confusion,
    Coordinate,
    Drawing,
    EffectCard,
    Equal,
    Fit,
    Group,
    Rule,
    Shape,
    Sizes,
    StandIn,
    Trait,
    Words,
)
from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import (
    MOTORS,
    Discrepancy,
    EffectKind,
    Memory,
    Parameter,
    Port,
    Values,
    joints,
    scalar,
)

STARTS_S = (
    (0.0, 0.02),
    (0.0, 0.08),
    (0.03, 0.0),
    (0.1, 0.0),
    (0.06, 0.06),
    (0.25, 0.05),
    (0.06, 0.25),
)
"""Time constants and dead times from which fits begin: either alone at a good and a poor drive's,
both, and each long beside the other."""
JOINT_S = 0.05
"""Spread of the dead time and of the time constant of a joint's drive: a slow bus, or a filter,"""
JOINT_STARTS_S = tuple((s,) for s in (0.003, 0.015, 0.08, 0.3))
"""and from where fits of either begin, apart by a factor of five."""


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    part = joints(index)
    dead_s, lag_s = scalar(values, "dead_time"), scalar(values, "time")
    flow.angles_rad[:, part] = flow.behind(flow.angles_rad[:, part], dead_s, lag_s, memory)
    if flow.smooth:
        flow.late_s += lag_s


EFFECT = EffectKind(
    name="following_lag",
    port=Port.MOTOR,
    components=MOTORS,
    parameters=(
        Parameter("time", "s", 0.0, 2.0, starts=(0.02,), step=1e-3, typical=0.05),
        Parameter("dead_time", "s", 0.0, 2.0, starts=(0.0,), step=1e-3, default=0.0, typical=0.05),
    ),
    operate=_operate,
    says=lambda component, v: (
        f"{component} follows its command late, with a time constant of {1e3 * v['time']:.3g} ms"
        + (f" after a dead time of {1e3 * v['dead_time']:.3g} ms" if v["dead_time"] else "")
    ),
    # a drive is not of first order
    discrepancy=Discrepancy(0.001, 0.003),
)


def _late_s(lag: Sizes) -> float:
    return lag["time"] + lag["dead_time"]


CARD = EffectCard(
    name=EFFECT.name,
    kind=EFFECT,
    listed=0,
    on={"command": EFFECT, "effort": EFFECT},
    says={
        "": "the axis follows late, with a time constant of {time}",
        "effort": (
            "the motion follows its effort late, with a time constant of {time} after a dead time "
            "of {dead_time}"
        ),
    },
    log_odds={
        # wears or is set by hand
        "command/lag": -1.0,
        # effort and position are mostly read by one clock; what filters make of it is fitted anyway
        "effort/lag": -4.0,
    },
    words=Words(
        noun="a drive of {part} that follows late",
        effort="a delay between effort and motion of {part}",
        several="drives of {part} that follow late",
        further="a further delay of {part}",
        regime="while {part} moves and just after it stops",
        axis_regime="in motion and just after it stops",
        sizes={"time": "time constant"},
    ),
    remedies={
        "": (
            "raise the gains in the control of {part}, or command it earlier: it is late by {size}"
        ),
        "dead": (
            "command {part} earlier, or look for what delays it (a bus, a slow cycle, a filter or "
            "ramp of its controller; higher gains shorten no dead time): it is late by {size}"
        ),
        "beside": (
            "raise the gains in the control of {part}, or command it earlier: it is late by {size},"
            " which a loop that rings as was found makes by itself"
        ),
        "effort": (
            "look for what delays the motion of {part}, or its readings, behind the effort (a "
            "filter, a slow bus, two clocks): it comes after the effort by {size}"
        ),
        "several": (
            "command {part} earlier, or raise the gains in their control (which shortens no dead "
            "time): they are late by {size}"
        ),
        "slide/": (
            "command {part} earlier, or look for what delays it (a smoothing filter of its "
            "controller; where a servo drives it, its gains): it is late by {size}"
        ),
    },
    drawing=Drawing(axis=("motor",)),
    traits=frozenset({Trait.DELAY, Trait.DRIVE_DELAY}),
    rule=Rule.SUM,
    also_added="dead_time",
    compensated=Compensated.AHEAD,
    confusions=(
        Confusion(
            "sensor_latency",
            stands_in={
                # a drive lags more often than a reading is late
                "command/lag": StandIn(-1.0, "time"),
                # with no drive between effort and position either clock may be off
                "effort/lag": StandIn(-0.5),
            },
            exactly_together_at="sensors",  # equal dead times everywhere
            axis=(
                "move the axis by hand against a switch that is recorded by the same clock: late "
                "readings show it late, a late drive does not"
            ),
            delta=(
                "Recording the arm angles too would distinguish a late drive from late readings."
            ),
            by_hand=(
                "record the arm angles (theta_1 to theta_3): a late drive shows in them, late "
                "readings do not"
            ),
            effort=1,
        ),
        Confusion(
            "viscous_friction",
            stands_in={
                # drag makes a drive late as its own loop does, and is mostly the smaller
                "command/lag": StandIn(-1.5, "dead_time"),
            },
            axis="change the drive's gain (friction lags less behind a stiffer drive){or_effort}",
        ),
        Confusion(
            "motor_azimuth",
            delta="The same path run the other way round would distinguish them.",
        ),
    ),
    by_hand=ByHand("record the arm angles (theta_1 to theta_3)", 6),
    fit=Fit(
        coordinates=(
            Coordinate("time", step=2e-3, low=0.0, high=2.0),
            Coordinate("dead_time", step=2e-3, low=0.0, high=2.0),
        ),
        # one and five samples at 50 Hz, for lag and dead time each
        shapes=tuple(Shape((0.0, 0.0), (i,), reach) for i in (0, 1) for reach in (0.02, 0.1)),
    ),
    group=Group("motors", 1),
    equals=(
        Equal(
            "viscous_friction",
            # a drag c behind a shaft of stiffness k is a first-order lag of c / k
            lambda lag, shaft: [{"coefficient": _late_s(lag) * shaft["stiffness"]}],
        ),
        Equal("sensor_latency", lambda lag, _: [{"time": _late_s(lag)}], common=True),
    ),
)
