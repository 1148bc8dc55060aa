"""What the play, or friction, of a lone axis has to do with a zero and a delay found beside it.

A zero may have been set on one side of it; a delay widens the gap in motion.
"""

from __future__ import annotations

from collections.abc import Sequence

from diagnosis.answer.records import Finding
from diagnosis.report.phrases.sizes import quantity
from diagnosis.report.sentences.telling_apart import HYSTERESIS, LONE

ABOUT_HALF = (0.75, 1.25)
"""Of half the play. Below, a zero set within the play is off by less; above, it is off as well."""
LATE = frozenset({"following_lag", "sensor_latency"})
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
        f"That is {which} half of {OF_BOTH_WAYS[play.effect]} (half of it is {shown}): a zero that"
        f" was set after coming from one side is off {much}."
    )


def wider_in_motion(finding: Finding, findings: Sequence[Finding]) -> str:
    """That a delay found beside play or friction widens the gap in motion; empty beside none."""
    if finding.effect not in HYSTERESIS or finding.component != LONE:
        return ""
    if "width" not in finding.parameters:
        return ""
    late_s = sum(map(_late_s, findings))
    if late_s <= 0.0:
        return ""
    late = quantity(late_s, "s", digits=2)
    return (
        f"In motion the gap is wider, by what the axis moves in twice the delay found beside it"
        f" ({late})."
    )


def _late_s(finding: Finding) -> float:
    """By how much it makes readings late in all [s]."""
    if finding.effect not in LATE:
        return 0.0
    return sum(one.components[0][0] for one in finding.parameters.values() if one.unit == "s")


def _half(play: Finding) -> float:
    return 0.5 * play.parameters["width"].components[0][0]


def _off(home: Finding) -> float:
    return abs(home.parameters["angle"].components[0][0])
