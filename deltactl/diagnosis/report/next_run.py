"""What would settle what is open: a motion or a measurement, the next run, or no run at all.

A lone axis has no job file of ours, so there all is said in words of the effects' cards; a delta
has its next run, and a sentence for the pairs that are hard to distinguish.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from deltactl.diagnosis.answer.corrected_robot import (
    corrected_alike,
    lasts,
    sure,
    sure_of_correction,
)
from deltactl.diagnosis.answer.how_sure import settled
from deltactl.diagnosis.answer.options import VERDICT
from deltactl.diagnosis.answer.records import Alternative, Diagnosis, Finding, OpenTie
from deltactl.diagnosis.answer.verdict import NAMELESS
from deltactl.diagnosis.report.names import (
    count,
    effect,
    listed,
    percent,
    sentence,
    spelled,
)
from deltactl.diagnosis.report.templates import TERMINAL, Ways, say
from deltactl.foundation.one_screen import Part
from deltactl.models.effects import VOCABULARY, card_of, confusion
from deltactl.models.effects.card import Confusion
from deltactl.models.effects.lone_axis import COMPONENT


def _known(finding: Finding) -> Iterator[tuple[Alternative, Confusion | None]]:
    """Each alternative with what the cards know of the pair."""
    for one in finding.alternatives:
        yield one, confusion(finding.effect, one.effect)


def _on_an_axis(known: Confusion | None, ways: Ways, pull_said: bool) -> str:
    """What separates a pair on a single axis; empty where no card knows.

    pull_said: as in the answer; what the robot file has need not be entered.
    """
    pulls = "" if pull_said else say("apart.say_what_pulls")
    text = known.axis if known is not None else ""
    return text.format(or_effort=ways.or_effort, say_what_pulls=pulls)


def way_apart(finding: Finding, ways: Ways = TERMINAL, pull_said: bool = False) -> str:
    """How a single axis' finding is separated from its tie; empty where no row says."""
    if finding.component != COMPONENT:
        return ""
    texts = (_on_an_axis(known, ways, pull_said) for _, known in _known(finding))
    return next(filter(None, texts), "")


def asks_for_effort(findings: Sequence[Finding]) -> bool:
    """Whether an effort would tell one of them from what it is tied with."""
    return any(
        known is not None and "{or_effort}" in known.axis
        for finding in findings
        if finding.component == COMPONENT
        for _, known in _known(finding)
    )


def hint(finding: Finding, ways: Ways = TERMINAL, pull_said: bool = False) -> str:
    """What would distinguish a finding from its alternatives; empty where no line says."""
    if finding.component == COMPONENT:
        way = way_apart(finding, ways, pull_said)
        return say("apart.hint", way=way) if way else ""
    texts = (known.delta for _, known in _known(finding) if known is not None)
    return next(filter(None, texts), "")


def measurement(effects: frozenset[str]) -> str:
    """What to measure to tell these effects apart."""
    cards = [card_of(name) for name in effects]
    pairs = [one for card in cards for one in card.confusions if one.other in effects]
    by_hand = [(one.effort, one.by_hand) for one in pairs if one.by_hand]
    alone = [(card.by_hand.effort, card.by_hand.text) for card in cards if card.by_hand]
    easiest = by_hand or alone
    return min(easiest)[1] if easiest else say("apart.measure")


def experiment_line(diagnosis: Diagnosis) -> str:
    """The next experiment in one sentence."""
    plan = diagnosis.next_experiment
    if plan is None:
        return ""
    gain, unit = plan.expected_delta_chi2, say("run.chi_square")
    one_sided = any(tie.minutes is None and not tie.needs_drive for tie in diagnosis.open_ties)
    says = say(
        "run.may_tell" if one_sided else "run.would_tell",
        minutes=_minutes(plan.minutes),
        apart=listed([spelled(name) for name in plan.tells_apart]) or say("run.them"),
        expected=say("run.expected", gain=gain, unit=unit) if math.isfinite(gain) else "",
    )
    return sentence(says)


def made_to_distinguish(finding: Finding, diagnosis: Diagnosis) -> bool:
    """Whether the proposed run is made to tell it from what else it may be."""
    plan = diagnosis.next_experiment
    alike: list[Finding | Alternative] = [finding, *finding.alternatives]
    mine = {effect(one.effect, one.component) for one in alike}
    apart = [spelled(name) for name in plan.tells_apart] if plan is not None else []
    return any(name in text for name in mine for text in apart)


def _minutes(minutes: float) -> str:
    shown = f"{minutes:.2g}"
    known = (
        "one_minute" if shown == "1" else "minutes" if math.isfinite(minutes) else "some_minutes"
    )
    return say(f"run.{known}", minutes=shown)


def tie_lines(diagnosis: Diagnosis) -> list[str]:
    """What stays open whatever runs, and what helps then."""
    return list(dict.fromkeys(tie_line(tie) for tie in diagnosis.open_ties))


def tie_line(tie: OpenTie) -> str:
    """One pair of explanations that a run tells apart on one condition, or not at all."""
    case = "on_one_condition" if tie.minutes is None else "no_run"
    helps = measurement(frozenset(name.split(" ")[0] for name in (*tie.one, *tie.other)))
    return say(
        "tie.needs_drive" if tie.needs_drive else f"tie.{case}",
        one=_names(tie.one),
        other=_names(tie.other),
        longest=_minutes(tie.minutes or 0.0),
        helps=helps,
    )


def _names(side: Sequence[str]) -> str:
    """'effect component' names as noun phrases; one effect at several places once."""
    parts: dict[str, list[str]] = {}
    for name in side:
        what, _, component = name.partition(" ")
        parts.setdefault(what, []).append(component)
    return listed([effect(what, *places) for what, places in parts.items()])


def written(diagnosis: Diagnosis, all_of_them: bool) -> str:
    """How many of the findings a corrected robot file holds."""
    kept, of = len(_kept_and_left(diagnosis, all_of_them)[0]), len(diagnosis.findings)
    case = "unchanged" if not kept else "all" if kept == of else "some"
    return say(f"saved.{case}", kept=kept, findings=count(of, "finding"))


def saved_part(diagnosis: Diagnosis, all_of_them: bool, ways: Ways = TERMINAL) -> Part:
    """Which findings a corrected robot file holds, which it leaves out and why."""
    lines, more = saved_lines(diagnosis, all_of_them, ways), say("saved.more", number="{number}")
    return Part(lines, more=more, short=2, rank=2)


def saved_lines(diagnosis: Diagnosis, all_of_them: bool, ways: Ways = TERMINAL) -> list[str]:
    """The same as sentences, by the numbers of the findings."""
    kept, left = _kept_and_left(diagnosis, all_of_them)
    findings = diagnosis.findings
    once = [one for one in findings if not lasts(one) and _event(one)]
    nameless = [one for one in findings if one.effect == NAMELESS]
    other = [one for one in findings if not lasts(one) and one not in (*once, *nameless)]
    groups = (("written", kept), ("left_out", left), ("once", once), ("no_name", nameless),
              ("no_entry", other))  # fmt: skip
    return [
        say(f"saved.{case}", which=listed([_in_file(one, findings) for one in group]),
            too=say("saved.too", way=ways.save_all) if ways.save_all else "")
        for case, group in groups
        if group
    ]  # fmt: skip


def _event(finding: Finding) -> bool:
    kind = VOCABULARY.get(finding.effect)
    return kind is not None and kind.event


def _in_file(finding: Finding, findings: Sequence[Finding]) -> str:
    """A finding by its number; of one that is not certain, how sure it is, or its correction."""
    number = findings.index(finding) + 1
    if finding.effect == NAMELESS or not lasts(finding) or settled(finding):
        return f"{number}"
    if finding.probability is None:
        return say("saved.number_open", number=number) if finding.alternatives else f"{number}"
    whichever = corrected_alike(finding) and sure_of_correction(finding) >= VERDICT.sure_enough
    sure_of = sure_of_correction(finding) if whichever else finding.probability
    case = "saved.number_whichever" if whichever else "saved.number_sure"
    return say(case, number=number, sure=percent(sure_of))


def done_part(
    effects: Sequence[tuple[str, str, str]], not_written: Sequence[tuple[Finding, str]]
) -> Part:
    """What has been done about each effect of a corrected robot file, as a part of a screen.

    effects: what each is, what compensates it, and why not where that is empty.
    not_written: findings that are not in the file, and why.
    """
    lines = [
        say("corrected.done" if how else "corrected.left", says=says, how=how or why_not)
        for says, how, why_not in effects
    ]
    lines += [say("corrected.not_written", says=one.says, why=why) for one, why in not_written]
    return Part(lines or [say("corrected.unchanged")], say("corrected.head"),
                say("saved.more", number="{number}"), short=2, turns=2)  # fmt: skip


def _kept_and_left(diagnosis: Diagnosis, all_of_them: bool) -> tuple[list[Finding], list[Finding]]:
    lasting = [one for one in diagnosis.findings if lasts(one)]
    kept = [one for one in lasting if all_of_them or sure(one, diagnosis)]
    return kept, [one for one in lasting if one not in kept]
