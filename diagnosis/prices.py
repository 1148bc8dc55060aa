"""What an explanation must earn, in chi-square: the more it can bend, the more."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from diagnosis.candidate import Candidate, Term
from diagnosis.free_shapes import FreeShape

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
LONG_WAVE = 50.0
"""A wave as long as its travel is one bend, and any shape looks so: it costs like a free one."""
WHOLE_TRAVEL = 0.97
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
    long = any(
        coordinate.parameter == "period" and at > coordinate.high + np.log(WHOLE_TRAVEL)
        for coordinate, at in zip(term.candidate.coordinates, term.at, strict=True)
    )
    return price(term.candidate) + (LONG_WAVE if long else 0.0)
