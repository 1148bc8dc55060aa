"""What the findings of a lone axis have to do with each other.

In: a finding and all of them. Out: sentences, empty where they have nothing to do with it. A zero
may have been set on one side of a play; a delay widens its gap in motion; a loop that rings lags by
itself; a force that differs with the speed makes a constant one a mean.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from deltactl.diagnosis.answer.picture import Picture
from deltactl.diagnosis.answer.records import Finding
from deltactl.diagnosis.answer.verdict import differs_with_speed
from deltactl.diagnosis.report.phrases.sizes import quantity
from deltactl.diagnosis.report.sentences.telling_apart import LONE
from deltactl.models.effects import Trait, card_of, has

ABOUT_HALF = (0.75, 1.25)
"""Of half the play. Below, a zero set within the play is off by less; above, it is off as well."""
MUCH_OF_DELAY = 0.5
"""Of a delay, from which on a loop that rings may well be all that is late."""


def beside_play(finding: Finding, findings: Sequence[Finding]) -> Finding | None:
    """The play or friction by which an offset may have come about; None where it is no such one."""
    if not has(finding.effect, Trait.ZERO) or finding.component != LONE:
        return None
    play = [
        one for one in findings if has(one.effect, Trait.HYSTERESIS) and "width" in one.parameters
    ]
    return next((one for one in play if _off(finding) <= ABOUT_HALF[1] * _half(one)), None)


def zero_of_play(finding: Finding, findings: Sequence[Finding]) -> str:
    """That the zero may have been set on one side of the play; empty where it was not."""
    play = beside_play(finding, findings)
    if play is None:
        return ""
    half = _half(play)
    near = _off(finding) >= ABOUT_HALF[0] * half
    which, much = ("about", "by as much") if near else ("less than", "by up to half of it")
    gap = card_of(play.effect).words.gap
    shown = quantity(half, play.parameters["width"].unit, digits=3).lstrip("+")
    return (
        f"That is {which} half of {gap} (half of it is {shown}): a zero that"
        f" was set after coming from one side is off {much}."
    )


def where_it_moved(finding: Finding, findings: Sequence[Finding], picture: Picture | None) -> str:
    """What a zero amounts to where the axis moved, with a ratio beside it and far from its zero."""
    ratio = next((one for one in findings if has(one.effect, Trait.RATIO)), None)
    if not has(finding.effect, Trait.ZERO) or finding.component != LONE or ratio is None:
        return ""
    told = None if picture is None else picture.covariates.get("position")
    if told is None or abs(middle := float(np.mean(told))) < float(np.ptp(told)):
        return ""
    angle, scale = finding.parameters["angle"], ratio.parameters["scale"]
    there = angle.components[0][0] + (scale.components[0][0] - 1.0) * middle
    size = quantity(abs(there), angle.unit, digits=2).lstrip("+")
    side = "above" if there > 0.0 else "below"
    return (
        f"That is at its zero, which lies far from where it moved: about"
        f" {quantity(middle, angle.unit, digits=3).lstrip('+')}, with the ratio found beside it, it"
        f" stands {size} {side} what it is told."
    )


def wider_in_motion(finding: Finding, findings: Sequence[Finding]) -> str:
    """That a delay found beside play or friction widens the gap in motion; empty beside none."""
    if not has(finding.effect, Trait.HYSTERESIS) or finding.component != LONE:
        return ""
    late_s = sum(map(_late_s, findings))
    if "width" not in finding.parameters or late_s <= 0.0:
        return ""
    late = quantity(late_s, "s", digits=3)
    return (
        f"In motion the gap is wider: the delay of {late} found beside it adds what the axis moves"
        f" in {quantity(2.0 * late_s, 's', digits=2)}."
    )


def of_a_ringing_loop(finding: Finding, findings: Sequence[Finding]) -> float:
    """By how much a loop that rings as was found beside a delay lags by itself [s]; 0 beside none.

    A loop of second order, damped against the ground, is late at a steady speed by 2 zeta / omega.
    """
    rings = [one for one in findings if has(one.effect, Trait.RINGING) and one.component == LONE]
    if not has(finding.effect, Trait.DRIVE_DELAY) or finding.component != LONE or not rings:
        return 0.0
    sizes = {name: one.components[0][0] for name, one in rings[0].parameters.items()}
    frequency_hz, damping = sizes.get("frequency", math.inf), sizes.get("damping", 0.0)
    return damping / (math.pi * frequency_hz)


def slowed_by_its_loop(finding: Finding, findings: Sequence[Finding]) -> bool:
    """Whether a loop that rings beside it may well be all that makes an axis late."""
    return of_a_ringing_loop(finding, findings) > MUCH_OF_DELAY * _late_s(finding) > 0.0


def lags_by_itself(finding: Finding, findings: Sequence[Finding]) -> str:
    """The same as a sentence."""
    if not slowed_by_its_loop(finding, findings):
        return ""
    by = quantity(of_a_ringing_loop(finding, findings), "s", digits=2)
    return (
        f"A position loop that rings as found beside it is late by {by} by itself, at any steady"
        " speed: then this is no dead time, and higher gains shorten it."
    )


def mean_over_speeds(finding: Finding, findings: Sequence[Finding]) -> str:
    """That a force is a mean where another was found to differ with the speed."""
    number = differs_with_speed(finding, findings)
    if not number:
        return ""
    return (
        f"It is what the speeds of this recording have in common: with what follows the speed"
        f" (finding {number}) the force at one speed, or one way, is another."
    )


def _half(play: Finding) -> float:
    return 0.5 * play.parameters["width"].components[0][0]


def _off(home: Finding) -> float:
    return abs(home.parameters["angle"].components[0][0])


def _late_s(finding: Finding) -> float:
    """By how much it makes readings late in all [s]."""
    if not has(finding.effect, Trait.DELAY):
        return 0.0
    return sum(one.components[0][0] for one in finding.parameters.values() if one.unit == "s")
