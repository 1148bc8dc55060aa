"""What an explanation must earn, in chi-square: the more it can bend, the more."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from diagnosis.estimation.splines import FreeShape
from diagnosis.plants.candidate import Candidate, Term

PRICE = 4.0
"""Chi-square each coordinate of a candidate has to earn beyond the others."""
RELUCTANCE = {
    "viscous_friction": 7.0,
    "payload": 12.0,
    # How far a friction-bound arm swings on when it stops comes free: where play and friction fit
    # alike, the play would have to stick like friction.
    "joint_friction": -PRICE,
    # Where a motion tells neither from an offset, the offset is the likelier mistake.
    "sensor_scale": 0.5,
    "sensor_crosstalk": 1.5,
}
"""A price beside that of the coordinates."""
IN_NAME_ONLY = 50.0
"""An effect that does not do what it is called after bends like any shape, and costs like one."""
WHOLE_TRAVEL = 0.97
LEAST_PLAY_RAD = 3e-4
"""A gear with less play than this only yields."""
RINGS = 0.4
"""Beyond this damping a spring is still before it has swung back once."""
GROUP_PRICE = 10.0
"""That three arms err alike is less likely than one other cause that looks the same."""
EVENT_PRICE = 14.0
FREE_PRICE = 26.0


@dataclass(frozen=True, slots=True, eq=False)
class Trial:
    """A start for a refit and its linearised gain."""

    start: Term
    gain: float
    log_p: float
    price: float


def price(candidate: Candidate) -> float:
    """What a candidate must earn."""
    if candidate.kind.event:
        return EVENT_PRICE
    together = GROUP_PRICE if candidate.members else 0.0
    return PRICE * len(candidate.moved) + RELUCTANCE.get(candidate.effect, 0.0) + together


def free_price(free: FreeShape) -> float:
    """What a free shape must earn: more than any named effect, and more the finer it is."""
    return FREE_PRICE + 2.0 * free.size


def price_of(term: Term) -> float:
    """What a term must earn where the fit has brought it."""
    return price(term.candidate) + (IN_NAME_ONLY if _in_name_only(term) else 0.0)


def _in_name_only(term: Term) -> bool:
    """A wave of its whole travel, which is one bend; a play of no width; what rings not once."""
    for coordinate, at in zip(term.candidate.coordinates, term.at, strict=True):
        match (term.candidate.effect, coordinate.parameter):
            case (_, "period") if at > coordinate.high + np.log(WHOLE_TRAVEL):
                return True
            case ("gear_backlash", "width") if at < LEAST_PLAY_RAD:
                return True
            case ("resonance", "damping") if at > RINGS:
                return True
    return False
