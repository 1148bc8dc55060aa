"""What findings have to do with each other: the rules for pairs, all of them in `RULES`.

In: a finding and those beside it. Out: a sentence, and whether it asks for another remedy. A zero
may have been set on one side of a play; a loop that rings lags by itself; a force that differs with
the speed makes a constant one a mean.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from deltactl.diagnosis.answer.how_sure import settled, times_s
from deltactl.diagnosis.answer.options import SAYING
from deltactl.diagnosis.answer.records import Diagnosis, Finding
from deltactl.diagnosis.answer.verdict import NAMELESS, claimed, differs_with_speed
from deltactl.diagnosis.report.names import part
from deltactl.diagnosis.report.sizes import quantity, unsigned
from deltactl.diagnosis.report.templates import Signed, say
from deltactl.models.effects import Trait, card_of, has
from deltactl.models.effects.lone_axis import COMPONENT
from deltactl.models.effects.units_in_use import said
from deltactl.models.robot import EffectEntry


def beside(finding: Finding, diagnosis: Diagnosis) -> list[str]:
    """What is reported of a finding of a single axis beside others of it."""
    if finding.component != COMPONENT:
        return []
    lines = [rule(finding, diagnosis) for rule in RULES]
    return [line for line in lines if line]


def other_remedy(finding: Finding, diagnosis: Diagnosis) -> bool:
    """Whether what was found beside it asks for the remedy in the row `beside` of its card."""
    if finding.component != COMPONENT:
        return False
    if has(finding.effect, Trait.ZERO):
        return play_that_moved(finding, diagnosis.findings) is not None
    if has(finding.effect, Trait.CONSTANT_FORCE):
        return bool(differs_with_speed(finding, diagnosis.findings))
    return bool(_lags_by_itself(finding, diagnosis))


def _first(diagnosis: Diagnosis, trait: Trait) -> Finding | None:
    """The strongest finding of a single axis with this trait."""
    of_axis = (one for one in diagnosis.findings if one.component == COMPONENT)
    return next((one for one in of_axis if has(one.effect, trait)), None)


def _about_a_zero(zero: Finding, diagnosis: Diagnosis) -> str:
    """What a zero amounts to where the axis moved, far from its zero, by the ratio beside it; else
    that it may have been set on one side of the play.
    """
    if not has(zero.effect, Trait.ZERO):
        return ""
    place = None if diagnosis.picture is None else diagnosis.picture.covariates.get("position")
    ratio, play = _first(diagnosis, Trait.RATIO), play_that_moved(zero, diagnosis.findings)
    middle = 0.0 if place is None else float(np.mean(place))
    if place is not None and ratio is not None and abs(middle) >= float(np.ptp(place)):
        angle, scale = zero.parameters["angle"], ratio.parameters["scale"]
        there = angle.components[0][0] + (scale.components[0][0] - 1.0) * middle
        size, at = unsigned(abs(there), angle.unit), unsigned(middle, angle.unit, digits=3)
        return say("pair.where_it_moved", middle=at, size=size, there=Signed(there))
    if play is None:
        return ""
    width = play.parameters["width"]
    half = unsigned(0.5 * width.components[0][0], width.unit, digits=3)
    return say("pair.zero_of_play", gap=card_of(play.effect).words.gap, half=half)


def play_that_moved(zero: Finding, findings: Sequence[Finding]) -> Finding | None:
    """The play or friction by which an offset may have come about; None where it is no such one."""
    if not has(zero.effect, Trait.ZERO) or zero.component != COMPONENT:
        return None
    plays = (one for one in findings if has(one.effect, Trait.HYSTERESIS))
    widths = ((one, one.parameters["width"]) for one in plays if "width" in one.parameters)
    return next(
        (one for one, width in widths if _least(zero) <= 0.5 * width.components[0][2]), None
    )


def _least(zero: Finding) -> float:
    """How far off it is at least, by its interval."""
    _, low, high = zero.parameters["angle"].components[0]
    return 0.0 if low < 0.0 < high else min(abs(low), abs(high))


def _lags_by_itself(delay: Finding, diagnosis: Diagnosis) -> str:
    """That a loop that rings may well be all that makes an axis late.

    A loop of second order, damped against the ground, is late at a steady speed by 2 zeta / omega.
    """
    rings = _first(diagnosis, Trait.RINGING)
    if rings is None or not has(delay.effect, Trait.DRIVE_DELAY):
        return ""
    sizes = {name: one.components[0][0] for name, one in rings.parameters.items()}
    late_s = sizes.get("damping", 0.0) / (math.pi * sizes.get("frequency", math.inf))
    if not late_s > SAYING.much_of_delay * sum(times_s(delay).values()) > 0.0:
        return ""
    return say("pair.lags_by_itself", by=quantity(late_s, "s", digits=2))


def _mean_over_speeds(force: Finding, diagnosis: Diagnosis) -> str:
    """That a constant force is a mean, beside one that differs with the speed."""
    number = differs_with_speed(force, diagnosis.findings)
    return say("pair.mean_over_speeds", number=number) if number else ""


RULES = (_about_a_zero, _lags_by_itself, _mean_over_speeds)
"""Beside these there are `uneven`, `harmonic`, `bearings`, `late_drives` and `together` (two)
below, which name several findings by one sentence: nine in all."""


def uneven(
    finding: Finding, findings: Sequence[Finding], known: Sequence[EffectEntry] = ()
) -> bool:
    """Whether an unknown follows the direction of a single axis though friction or play is found.

    known: effects of the robot file, from an earlier diagnosis. Friction and play are the same
    along the whole travel; what is left of the direction changes along it.
    """
    followed = finding.effect == NAMELESS and finding.depends_on == ["direction"]
    there = [*(one.effect for one in findings), *(one.effect for one in known)]
    return followed and any(has(one, Trait.HYSTERESIS) for one in there)


def harmonic(finding: Finding, known: Sequence[EffectEntry]) -> str:
    """That a periodic error is a harmonic of a known one, of the same part; else empty."""
    period = finding.parameters.get("period")
    for one in known:
        whole = one.parameters.get("period")
        if period is None or one.effect != finding.effect or not isinstance(whole, float):
            continue
        times = abs(whole) / abs(period.components[0][0])
        number = round(times)
        if number in range(1, 5) and abs(times / number - 1.0) < SAYING.same_period:
            size = said(abs(whole), period.unit)
            return say("pair.harmonic", says=finding.says, number=number, period=size)
    return ""


def bearings(findings: Sequence[Finding]) -> tuple[list[Finding], str]:
    """Two parts of what an axis' bearings need, as one phrase; none where one alone is certain."""
    both = [
        one
        for one in findings
        if has(one.effect, Trait.BEARING) and one.component == COMPONENT and certain(one)
    ]
    return (both, say("pair.bearings", part=part(COMPONENT))) if len(both) > 1 else ([], "")


def certain(finding: Finding) -> bool:
    """Whether it is called by its name alone."""
    return not finding.alternatives or settled(finding)


def late_drives(named: Sequence[Finding]) -> list[Finding]:
    """Drives that all follow late, which are remedied by one line; none where one does."""
    late = [one for one in named if has(one.effect, Trait.DRIVE_DELAY) and certain(one)]
    return late if len(late) > 1 else []


def together(findings: Sequence[Finding]) -> Iterator[str]:
    """Which corrections are made together: by the distance of a sensor, of zero and ratio."""
    single = [one for one in findings if one.component in (COMPONENT, "sensor")]
    by_distance = [
        one
        for one in single
        if has(one.effect, Trait.BY_DISTANCE) or one.depends_on == ["distance"]
    ]
    if len(by_distance) > 1:
        yield say("pair.distances")
    of_axis = [one.effect for one in single if one.component == COMPONENT and claimed(one)]
    if all(any(has(one, trait) for one in of_axis) for trait in (Trait.ZERO, Trait.RATIO)):
        yield say("pair.zero_and_ratio")
