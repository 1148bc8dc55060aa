"""What would settle what is open: a motion or a measurement, the next run, or no run at all.

A single axis has no job file of ours: there the effects' cards say what to measure. A delta has its
next run, and a sentence for the pairs that are hard to distinguish.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from deltactl.diagnosis.answer.corrected_robot import (
    corrected_alike,
    kept,
    lasts,
    sure_of_correction,
)
from deltactl.diagnosis.answer.how_sure import settled, sized
from deltactl.diagnosis.answer.options import VERDICT
from deltactl.diagnosis.answer.records import Alternative, Diagnosis, Finding, OpenTie
from deltactl.diagnosis.answer.verdict import NAMELESS
from deltactl.diagnosis.report.names import effect, listed, numbers, percent, sentence, spelled
from deltactl.diagnosis.report.templates import TERMINAL, Ways, say
from deltactl.foundation.one_screen import Part
from deltactl.models.effects import VOCABULARY, card_of, confusion
from deltactl.models.effects.card import Confusion
from deltactl.models.effects.lone_axis import COMPONENT


def _confusions(finding: Finding) -> list[Confusion]:
    """What the cards know of the finding and each of its alternatives."""
    known = (confusion(finding.effect, one.effect) for one in finding.alternatives)
    return [one for one in known if one is not None]


def asks_for_effort(findings: Sequence[Finding]) -> bool:
    """Whether an effort would distinguish one of them from what it is tied with."""
    of_axes = (one for one in findings if one.component == COMPONENT)
    return any("{or_effort}" in known.axis for one in of_axes for known in _confusions(one))


def hint(finding: Finding, answer: Diagnosis, ways: Ways = TERMINAL) -> str:
    """What would distinguish a finding from its alternatives; empty where no card knows."""
    if finding.component != COMPONENT:
        return next((one.delta for one in _confusions(finding) if one.delta), "")
    way = measured(finding, answer, ways)
    return say("apart.hint", way=way) if way else ""


def measured(finding: Finding, answer: Diagnosis, ways: Ways) -> str:
    """Motion or measurement of an axis that distinguishes its causes, as part of a sentence."""
    slides = "_slides" * (answer.fit.unit in ("m", "N"))
    pulls = "" if answer.pull_said else say(f"apart.say_what_pulls{slides}")
    texts = (
        one.axis.format(or_effort=ways.or_effort, say_what_pulls=pulls)
        for one in _confusions(finding)
        if finding.component == COMPONENT
    )
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
    gain = plan.expected_delta_chi2
    one_sided = any(tie.minutes is None and not tie.needs_drive for tie in diagnosis.open_ties)
    says = say(
        "run.would_tell",
        may="may" if one_sided else "would",
        minutes=_minutes(plan.minutes),
        apart=listed([spelled(name) for name in plan.tells_apart]) or say("run.them"),
        expected=say("run.expected", gain=gain) if math.isfinite(gain) else "",
    )
    if plan.job.get("path", {}).get("shape") == "fourier":
        says += say("run.of_joints")
    return sentence(says)


def made_to_distinguish(finding: Finding, diagnosis: Diagnosis) -> bool:
    """Whether the proposed run is made to distinguish it from what else it may be."""
    plan = diagnosis.next_experiment
    alike: list[Finding | Alternative] = [finding, *finding.alternatives]
    mine = {effect(one.effect, one.component) for one in alike}
    apart = [spelled(name) for name in plan.tells_apart] if plan is not None else []
    return any(name in text for name in mine for text in apart)


def _minutes(minutes: float) -> str:
    return say("run.minutes", minutes=f"{minutes:.2g}") if math.isfinite(minutes) else ""


def tie_lines(diagnosis: Diagnosis) -> list[str]:
    """What stays open whatever runs, and what helps then."""
    return list(dict.fromkeys(tie_line(tie) for tie in diagnosis.open_ties))


def tie_line(tie: OpenTie) -> str:
    """One pair of explanations that a run distinguishes on one condition, or not at all."""
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
    number, of = len(kept(diagnosis, all_of_them)), len(diagnosis.findings)
    return say("saved.some" if number else "saved.unchanged", kept=number, of=of)


def saved_lines(
    diagnosis: Diagnosis, all_of_them: bool, ways: Ways = TERMINAL, brief: bool = False
) -> list[str]:
    """What a corrected file holds, and why not the rest; brief: without how sure each is."""
    groups, in_file = dict[str, dict[int, str]](), kept(diagnosis, all_of_them)
    for number, finding in enumerate(diagnosis.findings, 1):
        name = f"{number}{'' if brief else _how_sure(finding)}"
        groups.setdefault(_case(finding, in_file), {})[number] = name
    too = say("saved.too", way=ways.save_all) if ways.save_all else ""
    cases = ("written", "left_out", "no_size", "once", "no_name", "no_entry")
    shown = [(case, numbers(groups[case], ways.rows)) for case in cases if case in groups]
    return [say(f"saved.{case}", which=which, too=too) for case, which in shown]


def _case(finding: Finding, in_file: Sequence[Finding]) -> str:
    """Whether it is written, and why not."""
    if lasts(finding):
        left_out = "left_out" if sized(finding) else "no_size"
        return "written" if finding in in_file else left_out
    kind = VOCABULARY.get(finding.effect)
    if kind is not None and kind.event:
        return "once"
    return "no_name" if finding.effect == NAMELESS else "no_entry"


def _how_sure(finding: Finding) -> str:
    """In brackets, of one that is not certain: how sure it is, or its correction."""
    if not lasts(finding) or settled(finding) or not sized(finding):
        return ""
    if finding.probability is None:
        return say("saved.open") if finding.alternatives else ""
    whichever = corrected_alike(finding) and sure_of_correction(finding) >= VERDICT.sure_enough
    sure_of = sure_of_correction(finding) if whichever else finding.probability
    return say("saved.whichever" if whichever else "saved.sure", sure=percent(sure_of))


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
    head, more = say("corrected.head"), say("saved.more", number="{number}")
    return Part(lines or [say("corrected.unchanged")], head, more, short=2, turns=2)
