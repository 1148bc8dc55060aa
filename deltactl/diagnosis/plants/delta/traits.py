"""Which tests make sense on a delta: by the names of its motors, sensors and covariates."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

from deltactl.diagnosis.plants.delta.candidates import lost_steps
from deltactl.diagnosis.plants.traits import Traits
from deltactl.models.effects import CARDS

MOTOR, SENSOR = "motor", "range_"


def delta_traits(inputs: Iterable[str], channels: Iterable[str]) -> Traits:
    """Traits of a delta with these input locations and channels."""
    inputs = list(inputs)
    motors = [location for location in inputs if location.startswith(MOTOR)]
    return Traits(
        events={location: partial(lost_steps, location) for location in motors},
        repeating=tuple(name for name in channels if name.startswith(SENSOR)),
        own_place={location: location.replace(MOTOR, "theta_") for location in inputs},
        sensible=sensible,
        units={location: "rad" if location in motors else "m" for location in inputs},
        build_effects=frozenset(
            name for name, card in CARDS.items() if card.build_spread is not None
        ),
        exactly={
            name: one.other
            for name, card in CARDS.items()
            for one in card.confusions
            if one.exactly
        },
        exactly_together={
            name: (len(motors), one.other, one.exactly_together_at)
            for name, card in CARDS.items()
            for one in card.confusions
            if one.exactly_together_at
        },
    )


def sensible(location: str, covariate: str, coarse: bool) -> bool:
    """A joint's own motion, a sensor's all: what else is tried with few knots only, or never."""
    elsewhere = covariate[-1] != location[-1]
    if location.startswith(MOTOR):
        if covariate.startswith("speed_range") or "," in covariate:
            return False
        neighbour = covariate.startswith("theta") and coarse
        return neighbour or not (covariate[-1] in "123" and elsewhere)
    if location.startswith(SENSOR):
        if covariate.startswith("speed_range"):
            return coarse and not elsewhere
        return not covariate.startswith(("speed", "torque")) and (coarse or "," not in covariate)
    return True
