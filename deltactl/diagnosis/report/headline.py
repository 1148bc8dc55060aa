"""The verdict of an answer in one sentence."""

from __future__ import annotations

from collections.abc import Sequence

from deltactl.diagnosis.answer.how_sure import likelier
from deltactl.diagnosis.answer.records import Diagnosis, Finding
from deltactl.diagnosis.answer.verdict import NAMELESS, claimed
from deltactl.diagnosis.answer.what_is_left import (
    doubtful_floor,
    headline_case,
    mostly_left,
    surely_nothing,
)
from deltactl.diagnosis.report.names import (
    all_followed,
    called,
    effect,
    listed,
    other_cause,
    part_of,
    percent,
    sentence,
)
from deltactl.diagnosis.report.pairs import bearings, certain
from deltactl.diagnosis.report.sizes import in_its_units, quantity
from deltactl.diagnosis.report.templates import say

IN_HEADLINE = 3
"""Findings that the headline names; of more it names two, and all have their own row below."""


def opening(diagnosis: Diagnosis, brief: bool = False, below: bool = True) -> list[str]:
    """The sentences an answer begins with: its verdict, or a doubt that goes before any verdict.

    brief: without the names of what a finding may be instead. below: all findings are named below.
    """
    says = headline(diagnosis, brief, below)
    if not diagnosis.doubts:
        return [says]
    first, *others = diagnosis.doubts
    right = say("headline.if_right", says=f"{says[:1].lower()}{says[1:]}")
    return [say("headline.settle", doubt=first), *others, right]


@in_its_units
def headline(diagnosis: Diagnosis, brief: bool = False, below: bool = True) -> str:
    """The verdict in one sentence. brief, below: as in `opening`."""
    fit, case = diagnosis.fit, headline_case(diagnosis)
    nothing, doubtful = diagnosis.probability_nothing_missing, doubtful_floor(fit)
    nameless = [one for one in diagnosis.findings if one.effect == NAMELESS]
    before, left = (quantity(m, fit.unit, digits=2) for m in (fit.rms_before_m, fit.rms_after_m))
    remains = doubtful or (case == "partly" and diagnosis.unexplained.share_of_mismatch > 0.0)
    says = say(
        "headline.none_known" if case == "nothing" and doubtful else f"headline.{case}",
        probably="" if surely_nothing(diagnosis) else say("headline.probably"),
        sure="" if nothing is None else say("headline.sure", sure=percent(nothing)),
        likely=percent(1.0 - (nothing or 0.0)),
        what=_what(diagnosis.findings, brief, below),
        other=say("headline.other") if nameless else "",
        remains=say("headline.remains", left=left, before=before) if remains else "",
        check=say("headline.check") if mostly_left(diagnosis) else "",
        left=left,
        enters=listed(list(dict.fromkeys(map(_enters, nameless[:IN_HEADLINE])))),
    )
    return sentence(says)


def _what(findings: Sequence[Finding], brief: bool, below: bool) -> str:
    """The findings with a name, as many as a headline takes."""
    shown = [finding for finding in findings if claimed(finding)]
    named = _named(shown, brief)
    if len(named) > IN_HEADLINE:
        case = "headline.more" if below else "headline.more_there"
        more = say(case, number=len(named) - IN_HEADLINE + 1)
        named = [*named[: IN_HEADLINE - 1], more]
    unsure = sum(not certain(one) for one in shown) if brief else 0
    if not unsure:
        return listed(named)
    of = "one" if len(shown) == 1 else "each" if unsure == len(shown) else "some"
    return say(f"headline.open_{of}", what=listed(named), open=unsure)


def _named(findings: Sequence[Finding], brief: bool) -> list[str]:
    """Findings by name, those of one kind at several parts as one where nothing else is open."""
    both, phrase = bearings(findings)
    alike: dict[str, list[Finding]] = {}
    for finding in findings:
        own = (
            finding.effect if brief or certain(finding) else f"{finding.effect}@{finding.component}"
        )
        alike.setdefault(phrase if finding in both else own, []).append(finding)
    return [phrase if same == both else _one_kind(same, brief) for same in alike.values()]


def _one_kind(same: Sequence[Finding], brief: bool) -> str:
    """Findings of one kind by name; one of them with the likeliest of what else it may be."""
    finding, *others = same
    places = dict.fromkeys(one.component for one in same)
    name = effect(finding.effect, *places) if others else called(finding)
    if brief or others or certain(finding):
        return name
    first = likelier(finding) or finding.alternatives[0]
    return say(
        "headline.either" if likelier(finding) is None else "headline.likelier",
        name=name,
        other=other_cause(finding.effect, first.effect, first.component),
    )


def _enters(finding: Finding) -> str:
    follows = all_followed(finding.depends_on)
    place = part_of(finding.effect, finding.component, finding.depends_on)
    case = "headline.enters_follows" if follows else "headline.enters"
    return say(case, place=place, follows=follows)
