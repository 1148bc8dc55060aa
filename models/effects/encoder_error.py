"""The angle encoder itself adds an error that repeats with the angle."""

from __future__ import annotations

from dataclasses import replace

from deltactl.models.effects.card import Drawing, EffectCard, Rule, Words
from deltactl.models.effects.flow import Flow
from deltactl.models.effects.kind import MOTORS, EffectKind, Memory, Port, Values
from deltactl.models.effects.transmission_error import (
    PARAMETERS,
    PERIODIC,
    SECOND,
    add_periodic,
    size_in_words,
)


def _operate(flow: Flow, index: int, values: Values, memory: Memory) -> None:
    add_periodic(flow.measured_rad, index, values)


EFFECT = EffectKind(
    name="encoder_error",
    port=Port.ENCODER,
    components=MOTORS,
    parameters=PARAMETERS,
    operate=_operate,
    says=lambda component, v: (
        f"the angle encoder of {component} has a periodic error of {size_in_words(v)}"
    ),
    order=0,
)

CARD = EffectCard(
    name=EFFECT.name,
    kind=EFFECT,
    listed=0,
    on={"command": replace(EFFECT, parameters=(*EFFECT.parameters, *SECOND))},
    says={
        "": "the encoder adds a periodic error of {amplitude} every {period}",
        "slide": "the scale or encoder adds a periodic error of {amplitude} every {period}",
    },
    words=Words(
        noun="a periodic error of the angle encoder of {part}",
        axis="a periodic error of the encoder of {part}",
        several="periodic errors of the angle encoders of {part}",
        further="a further periodic error of the encoder of {part}",
        regime="in step with the angle of {part}, on its encoder only",
        axis_regime="in step with the position",
    ),
    remedies={
        "": "centre the encoder of {part}: it errs by {size} periodically",
        "axis/": (
            "centre the encoder of {part}, or subtract its periodic error ({size}) from what it "
            "reads"
        ),
        "slide/": (
            "have the controller of {part} subtract the periodic error of its scale or encoder "
            "({size}), or align that anew"
        ),
    },
    drawing=Drawing(axis=("encoder",)),
    rule=Rule.PHASOR,
    left="no encoder has a part in moving",
    fit=PERIODIC,
)
