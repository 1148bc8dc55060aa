"""What an explanation must earn, in chi-square: the more it can bend, the more."""

from __future__ import annotations

from dataclasses import dataclass

from diagnosis.candidate import Candidate, Term
from diagnosis.free_shapes import FreeShape

PRICE = 4.0
"""Chi-square each coordinate of a candidate has to earn beyond the others."""
RELUCTANCE = {"viscous_friction": 7.0, "payload": 12.0, "joint_friction": -PRICE}
"""A price beside that of the coordinates. How far a friction-bound arm swings on when it stops
comes free: where play and friction fit alike, the play would have to stick like friction."""
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
    return FREE_PRICE + 2.0 * free.basis.shape[1]
