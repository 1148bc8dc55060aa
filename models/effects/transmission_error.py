"""The gear adds an error that repeats with the angle at its output."""

from __future__ import annotations

from dataclasses import replace

from deltactl.models.effects.card import (
    Compensated,
    Confusion,
    Drawing,
    EffectCard,
    Rule,
    StandIn,
    Trait,
    Words,
)
from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import MOTORS, Discrepancy, EffectKind, Memory, Values
from deltactl.models.effects.periodic import (
    PARAMETERS,
    PERIODIC,
    SECOND,
    add_periodic,
    size_in_words,
)
from deltactl.models.effects.port import Port


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    add_periodic(flow.angles_rad, index, values)


EFFECT = EffectKind(
    name="transmission_error",
    port=Port.GEAR,
    components=MOTORS,
    parameters=PARAMETERS,
    operate=_operate,
    says=lambda component, v: (
        f"the gear or coupling of {component} has a periodic error of {size_in_words(v)}"
    ),
    order=1,
    # one harmonic of several
    discrepancy=Discrepancy(0.001, 0.003),
)

CARD = EffectCard(
    name=EFFECT.name,
    kind=EFFECT,
    listed=1,
    # On an axis behind the play: by where the axis is, as readings of it show a wave.
    on={"command": replace(EFFECT, order=4, parameters=(*EFFECT.parameters, *SECOND))},
    says={
        "": "the gear adds a periodic error of {amplitude} every {period}",
        "slide": "the screw or belt adds a periodic error of {amplitude} every {period}",
    },
    log_odds={
        # errors that a reading shows: gears are made so that it does not
        "command/gear": -3.0,
        "command/teeth": -3.0,
    },
    words=Words(
        noun="a periodic error of the gear or coupling of {part}",
        axis="a periodic error of the gear, screw or belt of {part}",
        several="periodic errors of the gears or couplings of {part}",
        further="a further periodic error of the gear, screw or belt of {part}",
        regime="in step with the angle of {part}",
        axis_regime="in step with the position",
    ),
    remedies={
        "": (
            "enter the periodic error of {part}'s gear ({size}) in the robot file, and jobs "
            "compensate it; replace the gear only if that is not enough"
        ),
        "axis/": (
            "have the controller of {part} subtract the periodic error of its gear ({size}; many "
            "can learn it), and replace the gear only if that is not enough"
        ),
        "slide/": (
            "have the controller of {part} subtract the periodic error of its screw or belt "
            "({size}); look for a bent screw or a pulley out of centre, and replace that only if it"
            " is not enough"
        ),
    },
    drawing=Drawing(motor="gear", axis=("gear",)),
    traits=frozenset({Trait.ENTERED}),
    rule=Rule.PHASOR,
    compensated=Compensated.INVERSE,
    confusions=(
        Confusion(
            "encoder_error",
            stands_in={
                # encoders are made finer than gears
                "command/gear": StandIn(-1.0),
                "command/teeth": StandIn(-1.0),
            },
            axis=(
                "read the angle by other means at a few places (a second encoder, or a laser on a "
                "mirror at the axis): a gear's error moves the axis, an encoder's does not"
            ),
        ),
    ),
    fit=PERIODIC,
    runout_rad=1e-3,  # a gear whose input shaft runs a little out of true
)
