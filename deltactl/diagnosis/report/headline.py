"""The verdict of an answer in one sentence."""

from __future__ import annotations

from collections.abc import Sequence

from deltactl.diagnosis.answer.how_sure import likelier
from deltactl.diagnosis.answer.records import Diagnosis, Finding
from deltactl.diagnosis.answer.verdict import NAMELESS, claimed, too_little
from deltactl.diagnosis.answer.what_is_left import (
    doubtful_floor,
    headline_case,
    part_explained,
    partly,
    surely_nothing,
)
from deltactl.diagnosis.report.names import (
    all_followed,
    called,
    count,
    effect,
    listed,
    other_cause,
    part_of,
    percent,
    sentence,
)
from deltactl.diagnosis.report.pairs import bearings, certain
from deltactl.diagnosis.report.sizes import quantity
from deltactl.diagnosis.report.templates import say

MOST_UNNAMED = 4
"""Unknown errors that the headline names; all have their own title below it."""
IN_HEADLINE = 3
"""Findings that the headline names; of more it names two, and all have their own title below."""


def opening(diagnosis: Diagnosis, brief: bool = False) -> list[str]:
    """The sentences an answer begins with: its verdict, or a doubt that goes before any verdict.

    brief: without what a finding cannot be told from.
    """
    says = headline(diagnosis, brief)
    if not diagnosis.doubts:
        return [says]
    first, *others = diagnosis.doubts
    right = say("headline.if_right", says=f"{says[:1].lower()}{says[1:]}")
    return [say("headline.settle", doubt=first), *others, right]


def headline(diagnosis: Diagnosis, brief: bool = False) -> str:
    """The verdict in one sentence. brief: as in `opening`."""
    fit, case = diagnosis.fit, headline_case(diagnosis)
    nothing = diagnosis.probability_nothing_missing or 0.0
    left = quantity(fit.rms_after_m, fit.unit, digits=2)
    if case in ("nothing_missing", "probably_nothing"):
        doubtful = doubtful_floor(fit)
        none = say("headline.no_known" if doubtful else "headline.nothing")
        start = say(f"headline.{case}", nothing=none, sure=percent(nothing))
        end = say("headline.left" if doubtful else "headline.as_the_file_says", left=left)
        return sentence(f"{start}{end}")
    if case == "none_known":
        return _none_known(diagnosis, nothing, left)
    part, rest = partly(diagnosis)
    key = f"partly_{rest}" if case == "partly" and rest else case
    part = part_explained(diagnosis) if case == "explained_but" else part
    before, after = (quantity(m, fit.unit, digits=3) for m in (fit.rms_before_m, fit.rms_after_m))
    return sentence(
        say(
            f"headline.{key}",
            what=_what(diagnosis.findings, brief),
            part=say(
                f"part_of_it.{part if case != 'explained_but' else part_explained(diagnosis)}"
            ),
            left=left,
            before=before,
            after=after,
            enters=listed(_unnamed(diagnosis.findings)),
            likely=percent(1.0 - nothing),
        )
    )


def _none_known(diagnosis: Diagnosis, nothing: float, left: str) -> str:
    """That nothing with a name is missing, and what remains all the same."""
    rest = diagnosis.unexplained
    little = too_little(diagnosis.fit, rest.share_of_mismatch, found=False)
    return say(
        "headline.surely_none_known" if surely_nothing(nothing) else "headline.none_known",
        sure=percent(nothing),
        small=say("headline.small") if little else "",
        left=left,
        what=say("headline.unmatched" if rest.depends_on else "headline.unattributed"),
        end=say("rest.little" if little else "headline.longer"),
    )


def _what(findings: Sequence[Finding], brief: bool) -> str:
    """The findings with a name, as many as a headline takes."""
    shown = [finding for finding in findings if claimed(finding)]
    named = list(dict.fromkeys(map(called, shown))) if brief else _named(shown)
    if len(named) > IN_HEADLINE:
        more = say("headline.more", number=len(named) - IN_HEADLINE + 1)
        named = [*named[: IN_HEADLINE - 1], more]
    return listed(named)


def _named(findings: Sequence[Finding]) -> list[str]:
    """Findings by name, those of one kind at several parts as one where nothing else is open."""
    both, phrase = bearings(findings)
    alike: dict[str, list[Finding]] = {}
    for finding in findings:
        own = finding.effect if certain(finding) else f"{finding.effect}@{finding.component}"
        alike.setdefault(phrase if finding in both else own, []).append(finding)
    return [phrase if same == both else _one_kind(same) for same in alike.values()]


def _one_kind(same: Sequence[Finding]) -> str:
    """Findings of one kind by name; one of them with what it cannot be told from."""
    if len(same) > 1:
        return effect(same[0].effect, *dict.fromkeys(one.component for one in same))
    (finding,) = same
    name = called(finding)
    others = [other_cause(finding.effect, o.effect, o.component) for o in finding.alternatives]
    if certain(finding):
        return name
    if (likeliest := likelier(finding)) is not None:
        other = other_cause(finding.effect, likeliest.effect, likeliest.component)
        more = len(others) - 1
        beside = say("either.beside", others=count(more, "other")) if more > 1 else ""
        return say("either.likelier", name=name, other=other, beside=beside)
    case = "either.one" if len(others) == 1 else "either.several"
    return say(case, name=name, other=others[0], number=len(others))


def _unnamed(findings: Sequence[Finding]) -> list[str]:
    """Where errors without a name enter, and what they follow."""
    nameless = [one for one in findings if one.effect == NAMELESS]
    return list(dict.fromkeys(map(_enters, nameless)))[:MOST_UNNAMED]


def _enters(finding: Finding) -> str:
    follows = all_followed(finding.depends_on)
    place = part_of(finding.effect, finding.component, finding.depends_on)
    return say("enters.and_follows" if follows else "enters.at", place=place, follows=follows)
