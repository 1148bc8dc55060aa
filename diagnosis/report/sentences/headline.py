"""The verdict of an answer in one sentence."""

from __future__ import annotations

from collections.abc import Sequence

from diagnosis.answer.options import VERDICT
from diagnosis.answer.records import Diagnosis, Finding
from diagnosis.answer.verdict import NAMELESS, claimed, fits_worse, seen, too_little
from diagnosis.report.phrases import sureness, words
from diagnosis.report.phrases.fit_words import doubtful_floor
from diagnosis.report.phrases.percent import percent
from diagnosis.report.phrases.sizes import quantity
from diagnosis.report.sentences.telling_apart import LONE

MOST_NAMED = 4
"""Unknown errors that the headline names; all have their own title below it."""
NO_KNOWN = "o known effect is missing ({sure} sure). A {small}rest of {left} remains that {what}"
"""Where no test raises the alarm, and the size of what is left is no noise's."""
TELLS_MORE = ": a longer recording, or a motion that shows more, may tell what it is"
MOSTLY_LEFT = 0.5
"""Share of the mismatch that nothing explains, from which on the headline says so first."""
CHECK_FIRST = "first check that each column and the robot file are the right ones"
FINE_COURSE = "the fine course of the readings points to"
BOTH_FRICTIONS = frozenset({"joint_friction", "viscous_friction"})
"""Of an axis, in one phrase: they are two parts of what its bearings need."""
SO_LITTLE = ", too little to act on"
IN_HEADLINE = 3
"""Findings that the headline names; of more it names two, and all have their own title below."""


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
        return words.sentence(f"the mismatch is explained by {what}")
    if diagnosis.verdict == "partly_explained" and named:
        more = any(one.effect == "unknown" for one in findings)
        rest = "; another part is real and matches no known effect" if more else ""
        left = diagnosis.unexplained.share_of_mismatch
        part = "part"
        if fits_worse(diagnosis.fit):
            return words.sentence(f"{FINE_COURSE} {what}, and yet the fit as a whole is no better")
        if left >= MOSTLY_LEFT:
            part, rest = (
                "only a small part",
                f"; {100.0 * left:.0f} % of it is left ({CHECK_FIRST})",
            )
        elif _nearly_all(diagnosis) and not (more and _much_unknown(findings)):
            part = "nearly all"
            rest = "; a small rest is real and matches no known effect" if more else ""
        return words.sentence(f"{part} of the mismatch is explained by {what}{rest}")
    if unknown := [finding for finding in findings if finding.effect == "unknown"]:
        return words.sentence(
            "something is missing from the model that matches no known effect; "
            + words.listed([_enters(finding) for finding in unknown[:MOST_NAMED]])
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


def _nearly_all(diagnosis: Diagnosis) -> bool:
    """Whether next to nothing is left, also of what the tests take for noise."""
    fit = diagnosis.fit
    left = fit.rms_after_m**2 < VERDICT.faint_rest * fit.rms_before_m**2
    return left and diagnosis.unexplained.share_of_mismatch < VERDICT.faint_rest


def _much_unknown(findings: Sequence[Finding]) -> bool:
    """Whether what has no name is more than a faint part of the mismatch."""
    shares = [one.share_of_mismatch for one in findings if one.effect == NAMELESS]
    return not sum(shares) < VERDICT.faint_rest


def _named(findings: Sequence[Finding]) -> list[str]:
    """Findings by name, those of one kind at several parts as one where nothing else is open."""
    alike: dict[str, list[Finding]] = {}
    rubbing = [one for one in findings if one.effect in BOTH_FRICTIONS and _lone_and_certain(one)]
    both = rubbing if len(rubbing) == len(BOTH_FRICTIONS) else []
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
    """As surely as it is known, and in the noise only where what is left is that."""
    sure = diagnosis.probability_nothing_missing
    doubtful = doubtful_floor(diagnosis.fit)
    within = "as far as this recording shows" if doubtful else "within the noise"
    if sure is not None and sure < sureness.SETTLED:
        likely = percent(sure)
        return (
            f"Probably nothing is missing ({likely} sure): the machine behaves as its robot file"
            f" says, {within}."
        )
    return f"Nothing is missing: the machine behaves as its robot file says, {within}."


def _either(finding: Finding) -> str:
    """A finding by name, with what it cannot be told from."""
    name = words.effect(finding.effect, finding.component)
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
