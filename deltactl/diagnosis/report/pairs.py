"""What findings have to do with each other: the rules for pairs, all of them in `RULES`.

In: a finding and those beside it. Out: a sentence, and whether it asks for another remedy. A zero
may have been set on one side of a play; a loop that rings lags by itself; a force that differs with
the speed makes a constant one a mean.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from deltactl.diagnosis.answer.how_sure import settled, times_s
from deltactl.diagnosis.answer.options import SAYING
from deltactl.diagnosis.answer.records import Diagnosis, Finding
from deltactl.diagnosis.answer.verdict import NAMELESS, claimed, differs_with_speed
from deltactl.diagnosis.report.names import part
from deltactl.diagnosis.report.sizes import quantity, unsigned
from deltactl.diagnosis.report.templates import Signed, say
from deltactl.models.effects import Trait, card_of, has
from deltactl.models.effects.lone_axis import COMPONENT, said
from deltactl.models.robot import EffectEntry

Fields = Mapping[str, object]
Case = Callable[[Finding, Sequence[Finding], Diagnosis], Fields | None]


@dataclass(frozen=True, slots=True)
class Rule:
    """What is reported of a finding of a single axis beside others of it.

    of, beside: traits of both; an empty `beside` is an error without a name. case: what the
    template `pair.key` is filled in with; None where the rule does not apply. remedy: what has this
    trait then asks for the remedy in the row `beside` of its card. unless: not reported where
    another rule applies.
    """

    key: str
    of: Trait
    beside: Trait | None
    case: Case
    remedy: Trait | None = None
    unless: str = ""

    def fields(self, finding: Finding, diagnosis: Diagnosis) -> Fields | None:
        """Those of the template; None where the rule does not apply."""
        if not has(finding.effect, self.of) or finding.component != COMPONENT:
            return None
        others = [
            one
            for one in diagnosis.findings
            if (one.effect == NAMELESS if self.beside is None else has(one.effect, self.beside))
        ]
        return self.case(finding, others, diagnosis) if others else None


def beside(finding: Finding, diagnosis: Diagnosis) -> list[str]:
    """What is reported of it beside others."""
    given = {rule.key: rule.fields(finding, diagnosis) for rule in RULES}
    return [
        say(f"pair.{rule.key}", **fields)
        for rule in RULES
        if (fields := given[rule.key]) is not None and given.get(rule.unless) is None
    ]


def other_remedy(finding: Finding, diagnosis: Diagnosis) -> bool:
    """Whether what was found beside it asks for another remedy."""
    return any(
        rule.remedy is not None
        and has(finding.effect, rule.remedy)
        and rule.fields(finding, diagnosis) is not None
        for rule in RULES
    )


def _where_it_moved(zero: Finding, ratios: Sequence[Finding], all_: Diagnosis) -> Fields | None:
    """What a zero amounts to where the axis moved, far from its zero."""
    place = None if all_.picture is None else all_.picture.covariates.get("position")
    if place is None or abs(middle := float(np.mean(place))) < float(np.ptp(place)):
        return None
    angle, scale = zero.parameters["angle"], ratios[0].parameters["scale"]
    there = angle.components[0][0] + (scale.components[0][0] - 1.0) * middle
    size = unsigned(abs(there), angle.unit)
    return {"middle": unsigned(middle, angle.unit, digits=3), "size": size, "there": Signed(there)}


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


def _zero_of_play(zero: Finding, plays: Sequence[Finding], _: Diagnosis) -> Fields | None:
    """That the zero may have been set on one side of the play."""
    if (play := play_that_moved(zero, plays)) is None:
        return None
    width = play.parameters["width"]
    half = unsigned(0.5 * width.components[0][0], width.unit, digits=3)
    return {"gap": card_of(play.effect).words.gap, "half": half}


def _lags_by_itself(delay: Finding, loops: Sequence[Finding], _: Diagnosis) -> Fields | None:
    """That a loop that rings may well be all that makes an axis late.

    A loop of second order, damped against the ground, is late at a steady speed by 2 zeta / omega.
    """
    rings = [one for one in loops if one.component == COMPONENT]
    if not rings:
        return None
    sizes = {name: one.components[0][0] for name, one in rings[0].parameters.items()}
    late_s = sizes.get("damping", 0.0) / (math.pi * sizes.get("frequency", math.inf))
    if not late_s > SAYING.much_of_delay * sum(times_s(delay).values()) > 0.0:
        return None
    return {"by": quantity(late_s, "s", digits=2)}


def _mean_over_speeds(force: Finding, _: Sequence[Finding], all_: Diagnosis) -> Fields | None:
    number = differs_with_speed(force, all_.findings)
    return {"number": number} if number else None


RULES = (
    Rule("where_it_moved", Trait.ZERO, Trait.RATIO, _where_it_moved),
    Rule("zero_of_play", Trait.ZERO, Trait.HYSTERESIS, _zero_of_play, Trait.ZERO, "where_it_moved"),
    Rule("lags_by_itself", Trait.DRIVE_DELAY, Trait.RINGING, _lags_by_itself, Trait.DRIVE_DELAY),
    Rule("mean_over_speeds", Trait.FORCE, None, _mean_over_speeds, Trait.CONSTANT_FORCE),
)
"""Beside these there are `uneven`, `harmonic`, `bearings`, `late_drives` and `together` (two)
below, which name several findings by one sentence: ten in all."""


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
    """That a periodic error by a whole fraction of a known one's period is of the same part; else
    empty.
    """
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
