"""The gear adds an error that repeats with the angle at its output."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from deltactl.models.effects.card import (
    Compensated,
    Confusion,
    Coordinate,
    Drawing,
    EffectCard,
    Fit,
    Rule,
    Shape,
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
    scalar,
)
from deltactl.models.effects.units_in_use import said
from deltactl.models.linkage.vectors import cosine_and_sine
from deltactl.models.robot import FloatArray

PARAMETERS = (
    Parameter("amplitude", "rad", 0.0, 0.2, starts=(0.001,), typical=0.002),
    Parameter("period", "rad", 1e-3, 2.0 * np.pi, starts=(2.0 * np.pi,), step=1e-4, spread=1.0),
    Parameter("phase", "rad", -np.pi, np.pi, starts=(0.0,), default=0.0),
)


PERIODIC = Fit(
    coordinates=(
        Coordinate("amplitude", "sine", step=2e-4, low=-0.2, high=0.2),
        Coordinate("amplitude", "cosine", step=2e-4, low=-0.2, high=0.2),
        Coordinate("period", "log", step=1e-3, low=np.log(1e-3), high=np.log(2.0 * np.pi)),
    ),
    # Errors per turn of the arm that a gear or coupling may have.
    shapes=tuple(
        Shape((0.0, 0.0, float(np.log(2.0 * np.pi / n))), (0, 1), 2e-4)
        for n in (1, 2, 3, 4, 5, 6, 8, 10, 12, 15, 16, 20, 25, 30, 40, 50)
    ),
)
SECOND = (
    Parameter("amplitude_2", "rad", 0.0, 0.2, starts=(0.0005,), typical=0.001, default=0.0),
    Parameter("phase_2", "rad", -np.pi, np.pi, starts=(0.0,), default=0.0),
)
"""For a single axis: the second harmonic, which a gear's error has beside the first."""


def add_periodic(angles_rad: FloatArray, index: int, values: Values) -> None:
    """Add amplitude * sin(2 pi angle / period + phase) to column `index` of (n, 3), in place, and
    what there is of the second harmonic.
    """
    angle = angles_rad[:, index]
    turns = 2.0 * np.pi * angle / scalar(values, "period")
    _, sine = cosine_and_sine(turns + scalar(values, "phase"))
    angles_rad[:, index] = angle + scalar(values, "amplitude") * sine
    if "amplitude_2" in values:
        _, second = cosine_and_sine(2.0 * turns + scalar(values, "phase_2"))
        angles_rad[:, index] += scalar(values, "amplitude_2") * second


def size_in_words(values: Mapping[str, Any]) -> str:
    """Amplitude and period for the effect's sentence."""
    return " every ".join(said(values[name], "rad") for name in ("amplitude", "period"))


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
        "command/slow": -3.0,
        "command/teeth": -3.0,
        # trackers are finer than encoders are mounted: most joints show a wave a turn
        "pose/wave": -1.5,
        "pose/second": -1.5,
        "pose/gear": -2.0,
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
                "command/slow": StandIn(-1.0),
                "command/teeth": StandIn(-1.0),
                "pose/wave": StandIn(-0.5),
                "pose/second": StandIn(-0.5),
                "pose/gear": StandIn(-2.0),
            },
            axis=(
                "measure where it is by other means at a few places (a second encoder, a laser): "
                "the error of a gear or screw moves the axis, an encoder's does not"
            ),
        ),
    ),
    fit=PERIODIC,
    runout_rad=1e-3,  # a gear whose input shaft runs a little out of true
)
