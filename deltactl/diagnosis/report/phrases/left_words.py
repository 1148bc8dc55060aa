"""What is left after the findings, and where: at rest or in motion, in words."""

from __future__ import annotations

import math

from deltactl.diagnosis.answer.options import VERDICT
from deltactl.diagnosis.answer.records import Fit
from deltactl.diagnosis.answer.verdict import goes_on
from deltactl.diagnosis.report.phrases.sizes import quantity

MOSTLY_BY_PLACE = 0.7
"""Less scatter at a place than this share: over half of the noise's power is between places."""
MORE_PLACES = "More places make the answer surer, longer stays do not."
MORE_MOVES = "More moves, and to more places, make the answer surer; longer stays do not."
NEXT_TO_NOTHING = 0.01
"""Of what is left: less is not told to more digits."""
MOSTLY_IN_MOTION = 1.5
"""Times as much in motion as at rest: over two thirds of the power, where both last as long."""
FEWEST_MOVED = 1.0 / 3.0
"""Of the rests, in which an axis must have moved to be said to,"""
MOVED_OF_LEFT = 2.0
"""and by how many times what is left: one glide in hours is none."""


def doubtful_floor(fit: Fit) -> bool:
    """Whether what the tests take for noise may well be something else."""
    return not fit.sensor_noise or goes_on(fit) or said_of_rest(fit) or moves_at_rest(fit)


def said_of_rest(fit: Fit) -> bool:
    """Whether what is left is so much more than readings scatter at rest that it is said of it."""
    within = fit.scatter_within_m
    return within is not None and fit.rms_after_m > VERDICT.beyond_rest * within


def mostly_by_place(fit: Fit) -> bool:
    """Whether most of what counts as noise does not show in readings at one place."""
    within = fit.scatter_within_m
    return within is not None and within <= MOSTLY_BY_PLACE * fit.noise_floor_m


def scatter_within(fit: Fit, digits: int) -> str:
    """How much readings at one place scatter; of next to nothing, that it is little."""
    within_m = fit.scatter_within_m or 0.0
    least_m = NEXT_TO_NOTHING * fit.rms_after_m
    if within_m < least_m:
        return f"less than {quantity(least_m, fit.unit, digits=1)}"
    return f"only {quantity(within_m, fit.unit, digits=digits)}"


def persists(fit: Fit) -> str:
    """That what is left is much the same from one reading to the next, as a clause."""
    lasts, apart = (
        quantity(time_s or math.nan, "s", digits=2)
        for time_s in (fit.left_lasts_s, fit.left_apart_s)
    )
    return (
        f"it stays much the same for about {lasts} at a time (one reading every {apart} was used)"
    )


def where_left(fit: Fit, what: str) -> str:
    """Where most of it lies: in motion, or from place to place.

    what: a name of it, which begins the clause.
    """
    if fit.at_rest is None:
        return f"most of {what} differs from place to place, or comes with motion"
    rest, motion = (
        quantity(size, fit.unit, digits=2)
        for size in (fit.at_rest.left_m, fit.at_rest.left_in_motion_m)
    )
    if fit.at_rest.left_in_motion_m > MOSTLY_IN_MOTION * fit.at_rest.left_m:
        return f"most of {what} comes with motion ({motion} there, {rest} at rest)"
    return f"most of {what} differs from place to place ({rest} at rest, {motion} in motion)"


def record_more(fit: Fit) -> str:
    """What makes an answer surer where longer stays do not."""
    return MORE_PLACES if fit.at_rest is None else MORE_MOVES


def moves_at_rest(fit: Fit) -> bool:
    """Whether the axis moves while its command stands, by more than noise and in many rests."""
    found = fit.at_rest
    if found is None or found.rests == 0 or found.moved < FEWEST_MOVED * found.rests:
        return False
    return found.moved_by_m > MOVED_OF_LEFT * fit.rms_after_m


def moved_at_rest(fit: Fit, head: str, found_play: bool) -> str:
    """That it does, and what that calls for.

    head: what of the mismatch it is. found_play: whether play or friction was found all the same.
    """
    found = fit.at_rest
    assert found is not None
    by = quantity(found.moved_by_m, fit.unit, digits=2)
    moves = (
        f"{head} follows nothing that a test sees, yet it is more than noise: while its command"
        f" stands, the axis moves by up to {by} (in {found.moved} of {found.rests} rests)"
    )
    if found.load_known:
        return f"{moves}, beyond what the known load does to it: first check the sign of that load."
    hidden = "" if found_play else "; play and friction of that size hide behind it"
    return f"{moves}. Something pulls at it that this recording does not say{hidden}."
