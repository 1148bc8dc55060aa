"""A motion or a measurement that separates what a recording leaves tied, from the effects' cards.

A lone axis has no job file of ours, so there all is said in words; a delta has its next run, and a
sentence for the pairs that are hard to distinguish.
"""

from __future__ import annotations

from collections.abc import Sequence

from deltactl.diagnosis.answer.records import Finding
from deltactl.diagnosis.report.sentences.ways import TERMINAL, Ways
from deltactl.models.effects import Trait, card_of, confusion, has
from deltactl.models.robot import EffectEntry

Pair = frozenset[str]
SAY_WHAT_PULLS = (
    ". Or say in the robot file what pulls at it, as `gravity` ('deltactl init' has --hanging-nm "
    "and --slope-n for it; 0 where nothing does), and diagnose again"
)
LONE = "axis"
"""Component of a machine that is one axis."""
OTHERWISE = "repeat the motion with other speeds, spans and rests"


def _ways(finding: Finding, ways: Ways = TERMINAL, pull_said: bool = False) -> list[str]:
    """What separates an axis' finding from each alternative; empty where no card knows.

    pull_said: as in the answer; what the robot file has need not be entered.
    """
    say = "" if pull_said else SAY_WHAT_PULLS
    known = (confusion(finding.effect, one.effect) for one in finding.alternatives)
    texts = (one.axis if one is not None else "" for one in known)
    return [text.format(or_effort=ways.or_effort, say_what_pulls=say) for text in texts]


def beside_friction(
    finding: Finding, findings: Sequence[Finding], known: Sequence[EffectEntry] = ()
) -> bool:
    """Whether an unknown follows the direction of a lone axis though friction or play is found.

    known: effects of the robot file, from an earlier diagnosis. Friction and play are the same
    along the whole travel; what is left of the direction changes along it.
    """
    followed = finding.effect == "unknown" and finding.depends_on == ["direction"]
    there = [*(one.effect for one in findings), *(one.effect for one in known)]
    return followed and any(has(one, Trait.HYSTERESIS) for one in there)


UNEVEN = "friction or play of the axis that is not the same all along its travel"
"""What such an unknown is called."""


def telling_apart(findings: Sequence[Finding], pull_said: bool = False) -> list[str]:
    """A sentence for every pair of a lone axis that is tied."""
    lines: dict[Pair, str] = {}
    for finding in findings:
        apart = _ways(finding, pull_said=pull_said)
        for other, says in zip(finding.alternatives, apart, strict=True):
            pair = frozenset({finding.effect, other.effect})
            text = f"To tell {finding.effect} from {other.effect}: {says or OTHERWISE}."
            lines.setdefault(pair, text)
    return list(lines.values())


def way_apart(finding: Finding, ways: Ways = TERMINAL, pull_said: bool = False) -> str:
    """How a lone machine's finding is told from what it is tied with; empty where no row says."""
    if finding.component != LONE:
        return ""
    return next(filter(None, _ways(finding, ways, pull_said)), "")


def asks_for_effort(findings: Sequence[Finding]) -> bool:
    """Whether an effort would tell one of them from what it is tied with."""
    return any(
        known is not None and "{or_effort}" in known.axis
        for finding in findings
        if finding.component == LONE
        for known in (confusion(finding.effect, one.effect) for one in finding.alternatives)
    )


def hint(finding: Finding, ways: Ways = TERMINAL, pull_said: bool = False) -> str:
    """What would distinguish a finding from its alternatives; empty where no line says."""
    if finding.component == LONE:
        said = way_apart(finding, ways, pull_said)
        return f"To tell them apart: {said}." if said else ""
    known = (confusion(finding.effect, one.effect) for one in finding.alternatives)
    return next((one.delta for one in known if one is not None and one.delta), "")


def measurement(effects: frozenset[str]) -> str:
    """What to measure to tell these effects apart."""
    cards = [card_of(effect) for effect in effects]
    pairs = [one for card in cards for one in card.confusions if one.other in effects]
    by_hand = [(one.effort, one.by_hand) for one in pairs if one.by_hand]
    alone = [(card.by_hand.effort, card.by_hand.text) for card in cards if card.by_hand]
    if easiest := by_hand or alone:
        return min(easiest)[1]
    return "measure the platform from outside (pos_x to pos_z), or record the arm angles"
