"""A zero of a lone axis that stands off by about half of the play, or friction, found beside it."""

from __future__ import annotations

from collections.abc import Sequence

from diagnosis.answer.records import Finding
from diagnosis.report.phrases.sizes import quantity
from diagnosis.report.sentences.telling_apart import HYSTERESIS, LONE

ABOUT_HALF = (0.75, 1.25)
"""Of half the play. Below, a zero set within the play is off by less; above, it is off as well."""
OF_BOTH_WAYS = {
    "gear_backlash": "the play",
    "joint_friction": "the gap that friction leaves between its two directions",
}


def beside_play(finding: Finding, findings: Sequence[Finding]) -> Finding | None:
    """The play or friction by which an offset may have come about; None where it is no such one."""
    if finding.effect != "home_offset" or finding.component != LONE:
        return None
    play = [one for one in findings if one.effect in HYSTERESIS and "width" in one.parameters]
    return next((one for one in play if _off(finding) <= ABOUT_HALF[1] * _half(one)), None)


def zero_of_play(finding: Finding, findings: Sequence[Finding]) -> str:
    """That the zero may have been set on one side of the play; empty where it was not."""
    play = beside_play(finding, findings)
    if play is None:
        return ""
    half = _half(play)
    near = _off(finding) >= ABOUT_HALF[0] * half
    which, much = ("about", "by as much") if near else ("less than", "by up to half of it")
    shown = quantity(half, play.parameters["width"].unit, digits=3).lstrip("+")
    return (
        f"That is {which} half of {OF_BOTH_WAYS[play.effect]} ({shown}): a zero that was set after"
        f" coming from one side is off {much}."
    )


def _half(play: Finding) -> float:
    return 0.5 * play.parameters["width"].components[0][0]


def _off(home: Finding) -> float:
    return abs(home.parameters["angle"].components[0][0])
