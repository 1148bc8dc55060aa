"""How sure a finding is, in words and as odds."""

from __future__ import annotations

import math

from deltactl.diagnosis.answer.options import VERDICT
from deltactl.diagnosis.answer.records import Alternative, Diagnosis, Finding, PriorSensitivity
from deltactl.diagnosis.answer.verdict import NAMELESS, rather_unknown, seen
from deltactl.diagnosis.report.phrases import words
from deltactl.diagnosis.report.phrases.left_words import (
    doubtful_floor,
    mostly_by_place,
    said_of_rest,
)
from deltactl.diagnosis.report.phrases.percent import CERTAIN, percent
from deltactl.diagnosis.report.phrases.rivals import by_usage, rivals
from deltactl.models.effects import Trait, has
from deltactl.models.effects.lone_axis import COMPONENT

BEYOND_DOUBT_P = 1e-6
VERY_SURE_P = 1e-3
SURE_P = 0.01
LIKELY_P = 0.05
COMPLETE = "the robot file is complete"
SETTLED = 0.95
"""A finding more probable than this is not called open, whatever its alternatives."""
UNNAMED = ". There is an effect of this kind; which of the causes below it is remains open"
THERE = {
    "Beyond doubt": "Something is there beyond doubt",
    "Very sure": "Something is very surely there",
    "Sure": "Something is surely there",
    "Likely": "Something is probably there",
}
"""By the word for its p: that something acts, whatever it is."""
FEW_READINGS = "No single test on so few independent readings shows it; all of them together do."
CHI_SQUARE = "chi-square"
OF_NOISE = ", where noise alone makes up to about 10"
"""How to read what a fit gains or loses, said once: 10 is what one or two sizes gain by
chance in one recording of a few hundred."""

LONGER = "A longer recording would tell more surely."
AT_MORE_PLACES = "A recording at more places would tell more surely."
WITH_MORE_MOVES = "A recording with more moves, and to more places, would tell more surely."
HALF = 0.5
"""A part of a delay that may be smaller by more than this is not known."""

BY_THE_LOOP = 2.0
"""Times the smaller part of a delay from which on the same is the larger in a drive of another
order: of real servos fitted with one time constant and with two, none then changes sides."""


def word(p: float) -> str:
    """One phrase for a calibrated p."""
    if not math.isfinite(p):
        return "How sure this is could not be computed"
    if p < BEYOND_DOUBT_P:
        return "Beyond doubt"
    if p < VERY_SURE_P:
        return "Very sure"
    if p < SURE_P:
        return "Sure"
    return "Likely" if p < LIKELY_P else "Weak evidence"


def odds(p: float) -> str:
    """'1 in 20 000', for people; 'less than 1 in a million' where figures mean nothing more."""
    if p < BEYOND_DOUBT_P:
        return "less than 1 in a million"
    if p > CERTAIN:
        return "nearly all"
    if p > 0.1:
        return f"about {100.0 * p:.0f} of 100"
    each = 1.0 / p
    power = 10.0 ** max(0, math.floor(math.log10(each)) - 1)
    return f"about 1 in {round(each / power) * power:,.0f}"


MATTERS_LESS = "Take it for a guess until another recording shows it as well."


def by_priors(one: PriorSensitivity) -> str:
    """How a probability depends on the priors of sizes."""
    now, narrower, wider = (percent(x) for x in (one.probability, one.narrower, one.wider))
    return (
        f"The probability of {words.effect(one.effect, one.component)}, {now}, rests on an"
        " assumption: how large this usually is on such machines. Were it usually three times"
        f" smaller, the probability would be {narrower}; were it three times larger, {wider}."
        f" {MATTERS_LESS}"
    )


def is_about(one: PriorSensitivity, finding: Finding) -> bool:
    """Whether it is the probability of this finding."""
    return (one.effect, one.component) == (finding.effect, finding.component)


def by_priors_here(one: PriorSensitivity) -> str:
    """The same beside the finding that it is of."""
    narrower, wider = percent(one.narrower), percent(one.wider)
    return (
        "The readings alone do not settle this; it also hangs on how large such an error usually is"
        f" (three times smaller than assumed: {narrower} sure; three times larger: {wider})."
        f" {MATTERS_LESS}"
    )


def evidence(finding: Finding, nothing: str = "no known effect") -> str:
    """How sure a finding is, in a sentence; where it is open, with what else it may be.

    nothing: what is ruled out as the cause of an unknown.

    The p of its own test is for statisticians (`in_chi_square`): beside the probability of all that
    was weighed together it reads as another answer.
    """
    p, own = finding.evidence.p, finding.probability
    if own is None:
        said = f"{word(p)}: {by_noise(p)}" if math.isfinite(p) else word(p)
        return f"{said}{UNNAMED if is_open(finding) else ''}."
    if is_open(finding):
        this = "something that no list has" if finding.effect == NAMELESS else "this"
        return (
            f"{THERE[word(p)]}; whether it is {this} ({percent(own)}) or {rivals(finding)}, this"
            f" recording cannot tell{by_usage(finding)}."
        )
    if sure_of_one(finding):
        together = percent(own + sum(one.probability or 0.0 for one in finding.alternatives))
        return (
            f"{_upper(together)} sure that it is this ({percent(own)}) or {rivals(finding)}; no"
            " single test shows it."
        )
    cause = f"{nothing if finding.effect == NAMELESS else 'this'} is the cause"
    said = f"{percent(own)} sure that {cause}"
    if p >= LIKELY_P and not settled(finding):
        return f"Weak evidence: {said}, and no single test shows it."
    return f"{_upper(said)}. {FEW_READINGS}" if p >= LIKELY_P else f"{_upper(said)}."


def in_chi_square(finding: Finding, explained: bool) -> str:
    """The evidence for statisticians; explained: with how to read a chi-square."""
    gain = finding.evidence.delta_chi2
    if not math.isfinite(gain):
        return ""
    much = f"{gain:,.0f}".replace(",", "\u00a0")
    how = OF_NOISE if explained else ""
    p = finding.evidence.p
    told = math.isfinite(p) and finding.probability is not None
    alone = f"; its own test: {by_noise(p)}" if told else ""
    return f"Without it the fit is worse by {much} in {CHI_SQUARE}{how}{alone}."


def by_noise(p: float) -> str:
    """What a p means, as a clause."""
    return f"noise alone would look like this in {odds(p)} recordings"


def is_open(finding: Finding) -> bool:
    """Whether something acts, and the finding is not settled against its alternatives."""
    several = bool(finding.alternatives) and not rather_unknown(finding)
    return several and finding.evidence.p < LIKELY_P and not settled(finding)


def sure_of_one(finding: Finding) -> bool:
    """Whether it is surely there, or one of its alternatives, by all tests together alone."""
    own, others = finding.probability, [one.probability or 0.0 for one in finding.alternatives]
    if own is None or finding.effect == NAMELESS or finding.evidence.p < LIKELY_P:
        return False
    return bool(others) and not settled(finding) and own + sum(others) > SETTLED


def likelier(finding: Finding) -> Alternative | None:
    """The likeliest named alternative that is more probable than the finding, if any."""
    own = finding.probability
    named = [one for one in finding.alternatives if one.effect != NAMELESS]
    most = max(named, key=lambda one: one.probability or 0.0, default=None)
    if own is None or most is None or (most.probability or 0.0) <= own:
        return None
    return most


def settled(finding: Finding) -> bool:
    """Whether it is far more probable than all its alternatives together."""
    return finding.probability is not None and finding.probability > SETTLED


def late_in_all_s(finding: Finding) -> float | None:
    """Dead time and time constant together, where how they divide is not known.

    At low frequencies they act alike: a recording of slow motion shows their sum well, while the
    interval of either may begin at nothing. And both are those of a drive of first order: with two
    equal time constants, which may fit as well, the dead time is shorter by up to half of the time
    constant. None where the larger is surely most of what it is, much larger than the other, and no
    interval is as long as half the sum.
    """
    sizes = [finding.parameters.get(name) for name in ("dead_time", "time")]
    if not has(finding.effect, Trait.DRIVE_DELAY) or not all(sizes):
        return None
    parts = [one.components for one in sizes if one is not None]
    if any(len(part) != 1 for part in parts):
        return None
    sum_s = sum(part[0][0] for part in parts)
    value, low, _ = max(part[0] for part in parts)
    longest_s = max(high - low for ((_, low, high),) in parts)
    if value < BY_THE_LOOP * (sum_s - value):
        return sum_s
    return sum_s if low < HALF * value or HALF * sum_s < longest_s < math.inf else None


def after_its_effort(finding: Finding) -> bool:
    """Whether a delay is that of a motion behind the effort that makes it: a dead time alone."""
    lone = has(finding.effect, Trait.DRIVE_DELAY) and finding.component == COMPONENT
    return lone and set(finding.parameters) == {"dead_time"}


def called(finding: Finding) -> str:
    """A finding by the name of its effect."""
    if after_its_effort(finding):
        return words.of_effort(finding.effect, finding.component)
    return words.effect(finding.effect, finding.component)


def divided(total: str) -> str:
    """What is said of a delay of which only the sum is known."""
    return f"only the sum of {total} is known, not how it divides into dead time and time constant"


def false_alarm(diagnosis: Diagnosis) -> str:
    """What the p of 'nothing is missing' means; empty where the headline says as much.

    Where what is left is not surely noise, nothing is said of what noise would look like.
    """
    p = diagnosis.false_alarm_p
    if not math.isfinite(p):
        return "How often a machine without a fault would look like this could not be computed."
    nothing = diagnosis.probability_nothing_missing
    if nothing is None:
        return f"If the machine were exactly as the robot file says, {by_noise(p)}."
    if not diagnosis.findings and not seen(p) and nothing >= VERDICT.even:
        if diagnosis.verdict != "nothing_missing":
            return ""
        if nothing < SETTLED:
            if not (mostly_by_place(diagnosis.fit) or said_of_rest(diagnosis.fit)):
                return LONGER
            return AT_MORE_PLACES if diagnosis.fit.at_rest is None else WITH_MORE_MOVES
        if doubtful_floor(diagnosis.fit):
            sure = f"{_upper(percent(nothing))} sure that"
            # What effects of the file may leave hides what has no name.
            return (
                f"{sure} {'no further known effect is missing' if diagnosis.known else COMPLETE}."
            )
    if nothing >= VERDICT.even and seen(p):
        none = f"{_upper(percent(nothing))} sure that no known effect is missing"
        return f"{none}; yet {by_noise(p)}."
    if nothing >= VERDICT.even:
        return f"{_upper(percent(nothing))} sure that {COMPLETE}: {by_noise(p)}."
    incomplete = f"{_upper(percent(1.0 - nothing))} sure that the robot file is incomplete"
    few = p >= LIKELY_P and nothing < 1.0 - SETTLED
    return f"{incomplete}. {FEW_READINGS}" if few else f"{incomplete}: {by_noise(p)}."


def _upper(text: str) -> str:
    return text[:1].upper() + text[1:]
