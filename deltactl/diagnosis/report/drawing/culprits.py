"""Which parts of the drawing an effect on a component means."""

from __future__ import annotations

from collections.abc import Sequence

from deltactl.diagnosis.answer.records import Finding
from deltactl.diagnosis.report.drawing.scene import Mark
from deltactl.models.effects import card_of

ARMS = ("1", "2", "3")
AXES = ("x", "y", "z")


def parts_of(effect: str, component: str) -> list[str]:
    """Names of the parts of a delta's drawing; empty for a component that is not on it."""
    stem, last = component[:-1], component[-1:]
    drawing = card_of(effect).drawing
    if stem in ("motor", "joint") and last in ARMS:
        return [f"{drawing.motor}{last}"]
    if stem == "arm" and last in ARMS:
        return [f"{drawing.rod}{last}"]
    if component.startswith("range_") and last in AXES:
        return [f"sensor_{last}"]
    if component == "sensors":
        return [f"sensor_{axis}" for axis in AXES]
    if drawing.everywhere:
        return list(drawing.everywhere)
    if component == "joints":
        return [f"{drawing.motor}{arm}" for arm in ARMS]
    if component == "arms":
        return [f"{rod}{arm}" for arm in ARMS for rod in ("upper_arm", "forearm")]
    return {"frame": ["base"], "platform": ["platform"]}.get(component, [])


def lone_parts_of(effect: str, component: str) -> list[str]:
    """The same for a lone axis or a lone sensor, where every component is `axis`."""
    return list(card_of(effect).drawing.axis)


def marks_of(findings: Sequence[Finding], lone: bool) -> dict[str, list[Mark]]:
    """Part -> the findings that touch it, alternatives after the findings themselves."""
    find = lone_parts_of if lone else parts_of
    marks: dict[str, list[Mark]] = {}
    for number, finding in enumerate(findings, 1):
        for name in find(finding.effect, finding.component):
            marks.setdefault(name, []).append(Mark(number))
    for number, finding in enumerate(findings, 1):
        for other in finding.alternatives:
            for name in find(other.effect, other.component):
                if all(mark.number != number for mark in marks.setdefault(name, [])):
                    marks[name].append(Mark(number, maybe=True))
    return marks
