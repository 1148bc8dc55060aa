"""What the figures of a finding amount to: whether to act on it, and what else it may be."""

from __future__ import annotations

from typing import Literal

from deltactl.diagnosis.answer.finding import HUGE, IN_ALL, ParameterResult
from deltactl.diagnosis.answer.options import SAYING, VERDICT
from deltactl.diagnosis.answer.records import Alternative, Diagnosis, Finding, PriorSensitivity
from deltactl.diagnosis.answer.verdict import NAMELESS
from deltactl.models.effects import Trait, has
from deltactl.models.effects.lone_axis import COMPONENT

SCALE = "scale"
"""A parameter of which one is nothing."""
SHOWN_AS_ONE = 1.005
"""A sum of probabilities up to half a percent above one is shown as one."""


def settled(finding: Finding) -> bool:
    """Whether it is far more probable than all its alternatives together."""
    return finding.probability is not None and finding.probability > SAYING.settled_p


def sized(finding: Finding) -> bool:
    """Whether its main size is known: an interval that holds nothing may be of either sign."""
    name, size = next(iter(finding.parameters.items()), ("", None))
    if size is None or len(size.components) != 1:
        return True
    (_, low, high), nothing = size.components[0], 1.0 if name == SCALE else 0.0
    return not low < nothing < high


def unsure(probability: float | None) -> bool:
    """Whether what is taken as known was not settled when it was found."""
    return probability is not None and probability < SAYING.settled_p


def tied(finding: Finding) -> bool:
    """Whether it could as well be something else, by this recording."""
    return bool(finding.alternatives) and not settled(finding)


def likelier(finding: Finding) -> Alternative | None:
    """The likeliest named alternative that is more probable than the finding, if any."""
    own = finding.probability
    named = [one for one in finding.alternatives if one.effect != NAMELESS]
    most = max(named, key=lambda one: one.probability or 0.0, default=None)
    if own is None or most is None or (most.probability or 0.0) <= own:
        return None
    return most


def exclusive(finding: Finding) -> bool:
    """Whether the probabilities of a finding and its alternatives are shares of one whole."""
    given = [finding.probability, *(one.probability for one in finding.alternatives)]
    return sum(one or 0.0 for one in given) <= SHOWN_AS_ONE


def act_on(finding: Finding, certain: bool) -> Literal["now", "whichever", "if_confirmed"]:
    """Whether to act on a finding: at once, whichever of its causes it is, or once it is confirmed.

    certain: the corrected file holds it, whichever of them it is.
    """
    own, named = finding.probability, any(one.effect != NAMELESS for one in finding.alternatives)
    if not tied(finding):
        return "now"
    if not named:  # what no list has cannot be ruled out
        rest = sum(one.probability or 0.0 for one in finding.alternatives)
        return "now" if own is None or own > rest else "if_confirmed"
    if likelier(finding) is None and own is not None and certain:
        return "whichever" if own < VERDICT.sure_enough else "now"
    return "if_confirmed"


def is_about(sensitivity: PriorSensitivity, finding: Finding) -> bool:
    """Whether what hangs on the priors is the probability of this finding."""
    return (sensitivity.effect, sensitivity.component) == (finding.effect, finding.component)


def late_in_all(finding: Finding) -> ParameterResult | None:
    """Dead time and time constant together, where how they divide is not known.

    At low frequencies they act alike: a recording of slow motion shows their sum well, while the
    interval of either may begin at nothing. And both are those of a drive of first order: with two
    equal time constants, which may fit as well, the dead time is shorter by up to half of the time
    constant. None where the larger is surely most of what it is, much larger than the other, and no
    interval is as long as half the sum.
    """
    if not (parts := _delays(finding)):
        return None
    sum_s = sum(value for value, _, _ in parts)
    value, low, _ = max(parts)
    longest_s = max(high - low for _, low, high in parts)
    vague = value < SAYING.by_the_loop * (sum_s - value) or value > SAYING.by_the_loop * low
    vague |= sum_s < SAYING.by_the_loop * longest_s < HUGE
    return delay_in_all(finding) if vague else None


def _delays(finding: Finding) -> list[tuple[float, float, float]]:
    """Dead time and time constant with their intervals; empty without both."""
    sizes = [finding.parameters.get(name) for name in ("dead_time", "time")]
    parts = [one.components for one in sizes if one is not None]
    whole = has(finding.effect, Trait.DRIVE_DELAY) and [len(part) for part in parts] == [1, 1]
    return [part[0] for part in parts] if whole else []


def delay_in_all(finding: Finding) -> ParameterResult | None:
    """Dead time and time constant together; None of what has not both."""
    sum_s = sum(value for value, _, _ in _delays(finding))
    total = ParameterResult(value=sum_s, ci95=[], unit="s") if sum_s else None
    return finding.parameters.get(IN_ALL, total)


def after_its_effort(finding: Finding) -> bool:
    """Whether a delay is that of a motion behind the effort that makes it: a dead time alone."""
    alone = has(finding.effect, Trait.DRIVE_DELAY) and finding.component == COMPONENT
    return alone and set(times_s(finding)) == {"dead_time"}


def times_s(finding: Finding) -> dict[str, float]:
    """Its times [s], by parameter."""
    given = finding.parameters.items()
    return {n: p.components[0][0] for n, p in given if p.unit == "s" and n != IN_ALL}


def mostly_dead(finding: Finding) -> bool:
    """Whether most of a delay is a dead time, which no gain shortens, and both are known."""
    if not has(finding.effect, Trait.DRIVE_DELAY) or late_in_all(finding) is not None:
        return False
    times = times_s(finding)
    return times.get("dead_time", 0.0) > times.get("time", 0.0)


def minor(finding: Finding) -> bool:
    """Whether the model error would hardly change without it, nor is much of it its doing."""
    own = finding.own_share
    return own is not None and max(own, finding.share_of_mismatch) < SAYING.minor_share


def worth_a_table(finding: Finding, answer: Diagnosis, named: bool) -> bool:
    """Whether a table of an unknown takes away enough of what is left; True without a table.

    named: whether there are causes with a name beside it.
    """
    if finding.table is None:
        return True
    if named and finding.share_of_mismatch < SAYING.minor_share:
        return False
    without_m = finding.left_without_m
    return without_m is None or not without_m < SAYING.table_helps * answer.fit.rms_after_m
