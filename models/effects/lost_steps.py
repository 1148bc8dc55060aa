"""The motor falls out of step once and stays behind (or ahead) from then on."""

from __future__ import annotations

from deltactl.models.effects.card import Coordinate, Drawing, EffectCard, Fit, Search, Trait, Words
from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import (
    MOTORS,
    Discrepancy,
    EffectKind,
    Memory,
    Parameter,
    Port,
    Values,
    scalar,
)


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    short_rad = scalar(values, "steps") * flow.rad_per_step
    flow.angles_rad[flow.t_s >= scalar(values, "time"), index] -= short_rad


EFFECT = EffectKind(
    name="lost_steps",
    port=Port.MOTOR,
    components=MOTORS,
    parameters=(
        Parameter("steps", "microsteps", -20000.0, 20000.0, step=1.0, typical=100),
        Parameter("time", "s", -1e9, 1e9, step=0.05),
    ),
    operate=_operate,
    says=lambda component, v: (
        f"{component} lost {v['steps']:.0f} microsteps at {v['time']:.2f} s and stayed there"
    ),
    order=1,
    smooth=False,
    event=True,
    # when within a reading's time
    discrepancy=Discrepancy(0.0005, 0.0005),
)

CARD = EffectCard(
    name=EFFECT.name,
    kind=EFFECT,
    listed=1,
    on={"command": EFFECT},
    says={
        "": "the motor lost {steps} at {time} and stayed behind",
    },
    log_odds={
        # at one moment of all there were
        "command/jump": -6.0,
    },
    words=Words(
        noun="steps lost by {part}",
        regime="from one moment on",
        axis_regime="from one moment on",
        sizes={"time": "at"},
    ),
    remedies={
        "": (
            "home again; then run slower or softer, and look for what held {part} up: {size} were "
            "lost"
        ),
    },
    drawing=Drawing(axis=("motor",)),
    traits=frozenset({Trait.WHOLE_STEPS}),
    left="happened once: home the robot, and look why",
    fit=Fit(
        coordinates=(
            Coordinate("steps", step=2.0, low=-2e4, high=2e4),
            Coordinate("time", "frozen"),
        ),
        searched=Search.MOMENT,
    ),
)
