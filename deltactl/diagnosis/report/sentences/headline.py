"""The verdict of an answer in one sentence."""

from __future__ import annotations

from collections.abc import Sequence

from deltactl.diagnosis.answer.options import VERDICT
from deltactl.diagnosis.answer.records import Diagnosis, Finding
from deltactl.diagnosis.answer.verdict import NAMELESS, claimed, fits_worse, seen, too_little
from deltactl.diagnosis.report.phrases import sureness, words
from deltactl.diagnosis.report.phrases.left_words import doubtful_floor
from deltactl.diagnosis.report.phrases.percent import percent
from deltactl.diagnosis.report.phrases.sizes import quantity
from deltactl.diagnosis.report.sentences.telling_apart import LONE
from deltactl.models.effects import Trait, has

MOST_NAMED = 4
"""Unknown errors that the headline names; all have their own title below it."""
NO_KNOWN = "o known effect is missing ({sure} sure). A {small}rest of {left} remains that {what}"
"""Where no test raises the alarm, and the size of what is left is no noise's."""
TELLS_MORE = ": a longer recording, or a motion that shows more, may tell what it is"
MOSTLY_LEFT = 0.5
"""Share of the mismatch that nothing explains, from which on the headline says so first."""
NEARLY_ALL = "nearly all"
LITTLE_LEFT, HALF_LEFT = 0.1, 0.5
"""Of the mismatch as it is shown (root mean square): nearly all, or most of it, is explained."""
CHECK_FIRST = "first check that each column and the robot file are the right ones"
FINE_COURSE = "the fine course of the readings points to"
SETTLE = "Settle the unit first: "
IF_RIGHT = "If the unit is right all the same: "
SO_LITTLE = ", too little to act on"
IN_HEADLINE = 3
"""Findings that the headline names; of more it names two, and all have their own title below."""


def opening(diagnosis: Diagnosis) -> list[str]:
    """The sentences an answer begins with: its verdict, or a doubt that goes before any verdict."""
    says = headline(diagnosis)
    if not diagnosis.doubts:
        return [says]
    first, *others = diagnosis.doubts
    return [f"{SETTLE}{first}", *others, f"{IF_RIGHT}{says[:1].lower()}{says[1:]}"]


def headline(diagnosis: Diagnosis) -> str:
    """The verdict in one sentence."""
    findings = diagnosis.findings
    named = _named([finding for finding in findings if claimed(finding)])
    shown = named
    if len(named) > IN_HEADLINE:
        shown = [*named[: IN_HEADLINE - 1], f"{len(named) - IN_HEADLINE + 1} more, named below"]
    what = words.listed(shown)
    if diagnosis.verdict == "nothing_missing":
        return _nothing_missing(diagnosis)
    if diagnosis.verdict == "explained" and named:
        return words.sentence(_explained(diagnosis, what))
    if diagnosis.verdict == "partly_explained" and named:
        more = any(one.effect == "unknown" for one in findings)
        rest = "; another part is real and matches no known effect" if more else ""
        part = _how_much(diagnosis)
        if fits_worse(diagnosis.fit):
            return words.sentence(f"{FINE_COURSE} {what}, and yet the fit as a whole is no better")
        if diagnosis.unexplained.share_of_mismatch >= MOSTLY_LEFT:
            part, rest = "only a small part", f"; {_of_before(diagnosis)} is left ({CHECK_FIRST})"
        elif more and _much_unknown(findings):
            part = "part"
        elif more and part == NEARLY_ALL:
            rest = "; a small rest is real and matches no known effect"
        return words.sentence(f"{part} of the mismatch is explained by {what}{rest}")
    if unknown := [finding for finding in findings if finding.effect == "unknown"]:
        return words.sentence(
            "something is missing from the model that matches no known effect; "
            + words.listed(list(dict.fromkeys(map(_enters, unknown)))[:MOST_NAMED])
        )
    nothing = diagnosis.probability_nothing_missing
    if nothing is not None and not seen(diagnosis.false_alarm_p):
        if nothing >= VERDICT.even:
            return _none_known(diagnosis, nothing)
        likely = percent(1.0 - nothing)
        return (
            f"Something may be missing from the model (probability {likely}), too faint to say "
            "what: record longer, or a motion that shows more."
        )
    return "Something is missing from the model, and no known effect explains it."


def _none_known(diagnosis: Diagnosis, nothing: float) -> str:
    """That nothing with a name is missing, and what remains all the same."""
    fit, rest = diagnosis.fit, diagnosis.unexplained
    little = too_little(fit, rest.share_of_mismatch, found=False)
    text = NO_KNOWN.format(
        sure=percent(nothing),
        small="small " if little else "",
        left=quantity(fit.rms_after_m, fit.unit, digits=2),
        what="matches no known effect" if rest.depends_on else "no test can attribute",
    )
    start = "N" if nothing >= sureness.SETTLED else "Probably n"
    return f"{start}{text}{SO_LITTLE if little else TELLS_MORE}."


def _how_much(diagnosis: Diagnosis) -> str:
    """How much of the mismatch is gone, as a reader reckons it from the figures of the fit."""
    left = diagnosis.fit.rms_after_m / max(diagnosis.fit.rms_before_m, 1e-300)
    if left < LITTLE_LEFT and diagnosis.unexplained.share_of_mismatch < VERDICT.faint_rest:
        return NEARLY_ALL
    return "most" if left < HALF_LEFT else "part"


def _explained(diagnosis: Diagnosis, what: str) -> str:
    """Without reserve only where next to nothing is left, or what is left is surely noise."""
    part = _how_much(diagnosis)
    if part == NEARLY_ALL or not doubtful_floor(diagnosis.fit):
        return f"the mismatch is explained by {what}"
    left = quantity(diagnosis.fit.rms_after_m, diagnosis.fit.unit, digits=2)
    return (
        f"{part} of the mismatch is explained by {what}; what is left ({left}) follows nothing that"
        " a test sees"
    )


def _of_before(diagnosis: Diagnosis) -> str:
    """How much is left of how much."""
    fit = diagnosis.fit
    after, before = (
        quantity(size, fit.unit, digits=3) for size in (fit.rms_after_m, fit.rms_before_m)
    )
    return f"{after} of {before}"


def _much_unknown(findings: Sequence[Finding]) -> bool:
    """Whether what has no name is more than a faint part of the mismatch."""
    shares = [one.share_of_mismatch for one in findings if one.effect == NAMELESS]
    return not sum(shares) < VERDICT.faint_rest


def _named(findings: Sequence[Finding]) -> list[str]:
    """Findings by name, those of one kind at several parts as one where nothing else is open."""
    alike: dict[str, list[Finding]] = {}
    # Of an axis, in one phrase: they are two parts of what its bearings need.
    frictions = [one for one in findings if has(one.effect, Trait.BEARING)]
    rubbing = [one for one in frictions if _lone_and_certain(one)]
    both = rubbing if len(rubbing) > 1 else []
    for finding in findings:
        if finding in both:
            alike.setdefault("friction", []).append(finding)
            continue
        certain = _certain(finding)
        own = f"{finding.effect}@{finding.component}"
        alike.setdefault(finding.effect if certain else own, []).append(finding)
    return [
        f"dry and viscous friction in {words.part(same[0].component)}"
        if same == both
        else words.effect(same[0].effect, *dict.fromkeys(one.component for one in same))
        if len(same) > 1
        else _either(same[0])
        for same in alike.values()
    ]


def _certain(finding: Finding) -> bool:
    """Whether nothing else is open."""
    return not finding.alternatives or sureness.settled(finding)


def _lone_and_certain(finding: Finding) -> bool:
    return finding.component == LONE and _certain(finding)


def _nothing_missing(diagnosis: Diagnosis) -> str:
    """As surely as it is known; as the file says only where what is left is noise."""
    sure, fit = diagnosis.probability_nothing_missing, diagnosis.fit
    doubtful = doubtful_floor(fit)
    nothing = "no known effect is missing" if doubtful else "nothing is missing"
    start = nothing[:1].upper() + nothing[1:]
    if sure is not None and sure < sureness.SETTLED:
        start = f"Probably {nothing} ({percent(sure)} sure)"
    if not doubtful:
        return f"{start}: the machine behaves as its robot file says, within the noise."
    left = quantity(fit.rms_after_m, fit.unit, digits=2)
    return f"{start}; what is left ({left}) follows nothing that a test sees."


def _either(finding: Finding) -> str:
    """A finding by name, with what it cannot be told from."""
    name = sureness.called(finding)
    others = [words.rival(finding.effect, o.effect, o.component) for o in finding.alternatives]
    if not others or sureness.settled(finding):
        return name
    if (rival := sureness.likelier(finding)) is not None:
        likelier = words.rival(finding.effect, rival.effect, rival.component)
        more = len(others) - 1
        beside = f" (or {words.count(more, 'other')} that look the same)" if more > 1 else ""
        return f"{name} or, more probably, {likelier}{beside}"
    if len(others) == 1:
        return f"{name} (or {others[0]})"
    return f"{name} (or one of {len(others)} others that look the same)"


def _enters(finding: Finding) -> str:
    follows = words.listed([words.followed(name) for name in finding.depends_on])
    place = words.part_of(finding.effect, finding.component, finding.depends_on)
    at = f"it enters at {place}"
    return f"{at} and follows {follows}" if follows else at
