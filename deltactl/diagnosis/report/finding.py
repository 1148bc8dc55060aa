"""One finding in sentences: its size, how sure it is, where it shows, and what else it may be."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from deltactl.diagnosis.answer.how_sure import (
    alternatives_case,
    evidence_case,
    exclusive,
    is_about,
    late_in_all_s,
    level,
    usage_case,
)
from deltactl.diagnosis.answer.records import (
    Alternative,
    Diagnosis,
    Finding,
    ParameterResult,
    PriorSensitivity,
    Where,
)
from deltactl.diagnosis.answer.shape_of_a_finding import (
    changes_its_pace,
    friction_without_load,
    second_harmonic,
    too_few_periods,
)
from deltactl.diagnosis.answer.verdict import NAMELESS, as_well, rather_unknown
from deltactl.diagnosis.report.fit import without_unit_of
from deltactl.diagnosis.report.names import (
    by_noise,
    channel,
    effect,
    listed,
    negligible,
    other_cause,
    percent,
    sentence,
    upper,
)
from deltactl.diagnosis.report.pairs import beside
from deltactl.diagnosis.report.sizes import Size, quantity, sizes, told, unsigned
from deltactl.diagnosis.report.templates import say

MOST_NAMED = 4
"""Channels or stretches of time that a sentence names."""
Span = tuple[float, float]
UNKNOWN_SPAN: Span = (math.nan, math.nan)


def finding_title(finding: Finding) -> str:
    """The finding's own sentence, components spelled out."""
    says = finding.says or effect(finding.effect, finding.component)
    return sentence(say("finding.part_of_unknown", says=says) if rather_unknown(finding) else says)


def span_s(diagnosis: Diagnosis) -> Span:
    """First and last time of the recording; NaN where no picture tells."""
    picture = diagnosis.picture
    if picture is None or not len(picture.t_s):
        return UNKNOWN_SPAN
    return float(picture.t_s[0]), float(picture.t_s[-1])


def divided(finding: Finding) -> str:
    """Of a delay of which only the sum is known: that; empty of all else."""
    late_s = late_in_all_s(finding)
    if late_s is None:
        return ""
    return say("finding.only_the_sum", total=quantity(late_s, "s", digits=3))


def told_sizes(finding: Finding) -> Iterator[tuple[str, ParameterResult, Size]]:
    """What is reported of its parameters: name, figures, and as shown; no parts of a mere sum."""
    if divided(finding):
        return
    for name, result in told(finding.parameters).items():
        for size in sizes(finding.effect, name, result):
            yield name, result, size


def notes(finding: Finding, diagnosis: Diagnosis) -> list[str]:
    """Sentences that go with its size: of itself, and of what was found beside it."""
    picture = diagnosis.picture
    lines = [_without_load(finding), *beside(finding, diagnosis), _second_harmonic(finding)]
    if (wave := too_few_periods(finding, picture)) is not None:
        period = unsigned(wave.period, wave.unit, digits=3)
        share = percent(wave.share)
        lines.append(say("note.few_periods", period=period, waves=wave.waves, share=share))
    if changes_its_pace(finding, picture):
        lines.append(say("note.moves_on"))
    return [line for line in lines if line]


def _without_load(finding: Finding) -> str:
    """Of friction that a load makes larger: how much of it is there without one; else empty."""
    if (found := friction_without_load(finding)) is None:
        return ""
    interval, unit = found
    alone, least, most = (unsigned(size, unit) for size in interval)
    return say("note.with_load", alone=alone, least=without_unit_of(least, most), most=most)


def _second_harmonic(finding: Finding) -> str:
    """Of a periodic error of an axis that is no plain sine: its second wave, and both together."""
    if (found := second_harmonic(finding)) is None:
        return ""
    second, span, unit = found
    twice, across = (unsigned(size, unit, digits=3) for size in (second, span))
    return say("note.second_harmonic", twice=twice, across=across)


def how_sure(finding: Finding, diagnosis: Diagnosis) -> list[str]:
    """How sure it is, and what that hangs on."""
    few = too_few_periods(finding, diagnosis.picture) is not None
    hangs = [one for one in diagnosis.prior_sensitivity if is_about(one, finding)]
    return [evidence(finding, few), *(_by_priors("here", one) for one in hangs)]


def evidence(finding: Finding, few_periods: bool = False) -> str:
    """How sure a finding is, in a sentence; where it is open, with what else it may be.

    few_periods: of an unknown that may have a name that this recording cannot show.

    The p of its own test is for statisticians (`in_chi_square`): beside the probability of all that
    was weighed together it reads as another answer.
    """
    p, own, case = finding.evidence.p, finding.probability or 0.0, evidence_case(finding)
    nameless = finding.effect == NAMELESS
    word = say(f"level.{level(p)}")
    cause = "this" if not nameless else "nothing_here" if few_periods else "no_effect"
    return say(
        f"evidence.{case}",
        word=say("level.with_p", word=word, by_noise=by_noise(p)) if math.isfinite(p) else word,
        there=say(f"there.{level(p)}"),
        what=say("cause.unlisted" if nameless else "cause.this"),
        cause=say(f"cause.{cause}"),
        own=percent(own),
        upper_own=upper(percent(own)),
        together=upper(percent(own + sum(o.probability or 0.0 for o in finding.alternatives))),
        other_causes=other_causes(finding),
        usage=_by_usage(finding),
        few=say("evidence.few_readings"),
    )


def in_chi_square(finding: Finding, explained: bool) -> str:
    """The evidence for statisticians; explained: with how to read a chi-square."""
    gain, p = finding.evidence.delta_chi2, finding.evidence.p
    if not math.isfinite(gain):
        return ""
    told = math.isfinite(p) and finding.probability is not None
    return say(
        "evidence.in_chi_square",
        gain=f"{gain:,.0f}".replace(",", "\u00a0"),
        unit=say("evidence.chi_square"),
        how=say("evidence.of_noise") if explained else "",
        alone=say("evidence.own_test", by_noise=by_noise(p)) if told else "",
    )


def by_priors(one: PriorSensitivity) -> str:
    """How a probability depends on the priors of sizes, with the name of the effect."""
    return _by_priors("named", one)


def _by_priors(case: str, one: PriorSensitivity) -> str:
    now, narrower, wider = (percent(x) for x in (one.probability, one.narrower, one.wider))
    return say(
        f"priors.{case}",
        effect=effect(one.effect, one.component),
        now=now,
        narrower=narrower,
        wider=wider,
        guess=say("priors.guess"),
    )


def other_causes(
    finding: Finding, shown: Sequence[Alternative] | None = None, more: int = 0
) -> str:
    """'a (30 %) or b (15 %)'; shown: those to name, more: how many are only counted.

    A set of causes may hold several of them, so that their probabilities may come to more than what
    the finding leaves: then one share is reported for all of them.
    """
    named = finding.alternatives if shown is None else shown
    apart = exclusive(finding)
    names = [f"{_name(finding, one)}{_share(one) if apart else ''}" for one in named]
    names += [say("other_causes.more", number=more)] if more else []
    text = listed(names, "or")
    if apart:
        return text
    left = percent(max(1.0 - (finding.probability or 0.0), 0.0))
    return f"{text} ({left if len(names) == 1 else say('other_causes.one_or_several', share=left)})"


def as_well_line(finding: Finding) -> str:
    """Of what fits a settled finding's readings as well: that it is only rarer; else empty."""
    same = [one for one in finding.alternatives if as_well(one)]
    if not same:
        return ""
    if len(same) > 1:
        return sentence(say("other_causes.rarer_several", names=other_causes(finding, same)))
    return sentence(say("other_causes.rarer", name=_name(finding, same[0]), share=_share(same[0])))


def _by_usage(finding: Finding) -> str:
    """What the shares of an open finding say where the fit does not tell it from others: a clause;
    empty where each of them fits worse.
    """
    same = [_name(finding, one) for one in finding.alternatives if as_well(one)]
    return say(f"usage.{usage_case(finding)}", names=listed(same, "or"))


def _name(finding: Finding, other: Alternative) -> str:
    return other_cause(finding.effect, other.effect, other.component)


def _share(other: Alternative) -> str:
    return "" if other.probability is None else f" ({percent(other.probability)})"


def memory_line(finding: Finding) -> str:
    """Of something unknown: whether what came before counts."""
    if finding.effect != NAMELESS or finding.has_memory is None:
        return ""
    return say("finding.memory" if finding.has_memory else "finding.no_memory")


def where_line(finding: Finding, span: Span = UNKNOWN_SPAN) -> str:
    """In which channels, when (unless all the time), and in which regime it shows."""
    where = finding.where
    axes = [_the(channel(axis)) for axis in where.axes[:MOST_NAMED]]
    regime = where.regime if finding.effect != NAMELESS else ""
    shown = [f"in {listed(axes)}" if axes else "", _times(where, *span), regime]
    if not any(shown):
        return ""
    return sentence(say("finding.shows", where=", ".join(filter(None, shown))))


def _the(name: str) -> str:
    """A channel of which there is one, in a sentence."""
    return name if name[-1:].isdigit() or name[-2:-1] == " " else f"the {name}"


def stretches(where: Where, start_s: float, end_s: float) -> list[tuple[float, float]]:
    """Those that say something: not the whole recording, or all of several."""
    times_s, slack = where.times_s, 0.02 * (end_s - start_s)
    if len(set(where.recordings)) > 1:
        return []
    if len(times_s) == 1 and times_s[0][0] <= start_s + slack and times_s[0][1] >= end_s - slack:
        return []
    return list(times_s)


def _times(where: Where, start_s: float, end_s: float) -> str:
    times = stretches(where, start_s, end_s)
    if len(times) == 1 and times[0][1] >= end_s:
        return say("finding.from_on", start=times[0][0])
    shown = [say("finding.from_to", start=start, end=end) for start, end in times[:MOST_NAMED]]
    more = len(times) - len(shown)
    return listed([*shown, say("finding.more_times", number=more)] if more > 0 else shown)


def alternatives_line(finding: Finding) -> str:
    """What this recording cannot distinguish from the finding; empty where that is said already."""
    case = alternatives_case(finding)
    if case == "settled":
        worse = _alternatives_of_settled(finding)
        head = say("alternatives.far_less_head")
        rest = say("alternatives.far_less", head=head, names=worse) if worse else ""
        return " ".join(filter(None, (as_well_line(finding), rest)))
    return say(f"alternatives.{case}", names=other_causes(finding))


def _alternatives_of_settled(finding: Finding) -> str:
    """Each that fits worse with its probability, and once for all of those that have next to none;
    empty where none does.
    """
    worse = [one for one in finding.alternatives if not as_well(one)]
    rest = [one for one in worse if negligible(one.probability)]
    if len(rest) < 2:
        return other_causes(finding, worse) if worse else ""
    names = listed([_name(finding, one) for one in rest])
    others = [one for one in worse if one not in rest]
    shown = [other_causes(finding, others)] if others else []
    return "; ".join([*shown, say("other_causes.each", names=names, share=percent(0.0))])
