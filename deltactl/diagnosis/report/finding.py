"""One finding in sentences: its sizes, how sure it is, where it shows, and what else it may be."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from deltactl.diagnosis.answer.how_sure import delay_in_all, exclusive, is_about, late_in_all, tied
from deltactl.diagnosis.answer.records import (
    Alternative,
    Diagnosis,
    Finding,
    PriorSensitivity,
    Where,
)
from deltactl.diagnosis.answer.verdict import NAMELESS, as_well, rather_unknown
from deltactl.diagnosis.report.names import (
    by_noise,
    channel,
    effect,
    listed,
    other_cause,
    percent,
    sentence,
    upper,
)
from deltactl.diagnosis.report.sizes import Size, quantity, reported, sizes
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
    """First and last time of the recording; NaN where there is no picture."""
    picture = diagnosis.picture
    if picture is None or not len(picture.t_s):
        return UNKNOWN_SPAN
    return float(picture.t_s[0]), float(picture.t_s[-1])


def shown_sizes(finding: Finding) -> Iterator[tuple[str, Size]]:
    """Its parameters by name, as shown; the sum first of a delay, and alone if no part is known."""
    late = late_in_all(finding)
    if (total := late or delay_in_all(finding)) is not None:
        yield from (("time", size) for size in sizes(finding.effect, "late_in_all", total))
    for name, result in (reported(finding.parameters) if late is None else {}).items():
        yield from ((name, size) for size in sizes(finding.effect, name, result))


def how_sure(finding: Finding, diagnosis: Diagnosis) -> list[str]:
    """How sure it is, and what that depends on."""
    evidence = finding.evidence
    facts = [] if math.isnan(evidence.p) else [say("sure.test", p=by_noise(evidence.p))]
    if math.isfinite(evidence.delta_chi2):
        facts.append(say("sure.gain", gain=f"{evidence.delta_chi2:,.0f}".replace(",", "\u00a0")))
    case = "sure.not_known" if finding.probability is None else "sure.cause"
    line = upper(say(case, sure=percent(finding.probability or 0.0), facts=in_brackets(facts)))
    hangs = [one for one in diagnosis.prior_sensitivity if is_about(one, finding)]
    return [line, *map(by_priors, hangs)]


def in_brackets(facts: Sequence[str]) -> str:
    """' (a; b)'; empty where there are none."""
    return f" ({'; '.join(facts)})" if any(facts) else ""


def by_priors(one: PriorSensitivity) -> str:
    """How a probability depends on the priors of sizes."""
    now, narrower, wider = (percent(x) for x in (one.probability, one.narrower, one.wider))
    name = effect(one.effect, one.component)
    return say("sure.by_priors", effect=name, now=now, narrower=narrower, wider=wider)


def other_causes(
    finding: Finding, shown: Sequence[Alternative] | None = None, in_full: bool = False
) -> str:
    """'a (30 %) or b (15 %)'; shown: those to name; in_full: how much worse each fits.

    A set of causes may hold several of them, so that their probabilities may come to more than what
    the finding leaves: then one share is reported for all of them.
    """
    named = finding.alternatives if shown is None else shown
    if not finding.alternatives and finding.probability is not None:
        return say("other.nothing", share=percent(1.0 - finding.probability))
    apart = exclusive(finding)
    names = [_other(finding, one, apart, in_full) for one in named]
    if apart or not names:
        return listed([*names, *_none_of_them(finding, named)], "or")
    text = listed(names, "or")
    left = percent(max(1.0 - (finding.probability or 0.0), 0.0))
    return f"{text} ({left if len(names) == 1 else say('other.one_or_several', share=left)})"


def _none_of_them(finding: Finding, named: Sequence[Alternative]) -> list[str]:
    """The share that neither the finding nor any other cause has; none where it is not known."""
    given = [finding.probability, *(one.probability for one in named)]
    known = [one for one in given if one is not None]
    if not named or len(known) < len(given) or len(named) < len(finding.alternatives):
        return []
    left = percent(max(1.0 - sum(known), 0.0))
    return [say("other.none_of_them", share=left)] if left != percent(0.0) else []


def _other(finding: Finding, other: Alternative, apart: bool, in_full: bool) -> str:
    known = apart and other.probability is not None
    facts = [percent(other.probability or 0.0)] if known else []
    if in_full and as_well(other):
        facts.append(say("other.fits_as_well"))
    elif in_full and math.isfinite(other.delta_chi2):
        facts.append(say("other.worse", size=f"{other.delta_chi2:.1f}"))
    return f"{other_cause(finding.effect, other.effect, other.component)}{in_brackets(facts)}"


def open_causes(finding: Finding) -> list[Alternative]:
    """What else it could be: everything, or what fits as well as a finding that is settled."""
    return [one for one in finding.alternatives if tied(finding) or as_well(one)]


def where_line(finding: Finding, span: Span = UNKNOWN_SPAN) -> str:
    """In which channels, when (unless all the time), and in which regime it shows."""
    where = finding.where
    names = [channel(axis) for axis in where.axes[:MOST_NAMED]]
    axes = [one if one[-1:].isdigit() or one[-2:-1] == " " else f"the {one}" for one in names]
    regime = where.regime if finding.effect != NAMELESS else ""
    memory = ""
    if finding.effect == NAMELESS and finding.has_memory is not None:
        memory = say("finding.memory" if finding.has_memory else "finding.no_memory")
    shown = [f"in {listed(axes)}" if axes else "", _times(where, *span), regime, memory]
    where_ = ", ".join(filter(None, shown))
    return sentence(say("finding.shows", where=where_)) if where_ else ""


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
    shown = [say("finding.from_to", start=start, end=end) for start, end in times[:MOST_NAMED]]
    more = len(times) - len(shown)
    return listed([*shown, say("finding.more_times", number=more)] if more > 0 else shown)


def without_line(finding: Finding, unit: str, before: float) -> str:
    """The model error without it, the others fitted again, and with it alone; empty if unknown."""
    if finding.left_without_m is None:
        return ""
    says = say("finding.without", size=quantity(finding.left_without_m, unit, digits=3))
    if finding.alone_m is None or finding.alone_ci95_m is None:
        return says
    left, *ends = (quantity(x, unit, digits=3) for x in (finding.alone_m, *finding.alone_ci95_m))
    gone = percent(1.0 - finding.alone_m / max(before, 1e-300))
    return f"{says} {say('finding.alone', gone=gone, size=left, low=ends[0], high=ends[1])}"
