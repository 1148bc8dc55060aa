"""Which parts of the drawing an effect on a component means."""

from __future__ import annotations

from collections.abc import Sequence

from deltactl.diagnosis.answer.records import Finding
from deltactl.diagnosis.report.drawing.scene import Mark

ARMS = ("1", "2", "3")
AXES = ("x", "y", "z")

_GEAR = frozenset({"gear_backlash", "gear_ratio", "transmission_error"})
_BEARING = frozenset({"joint_friction", "viscous_friction", "stribeck_friction"})

_LONE: dict[str, str] = {
    "gear_backlash": "gear",
    "gear_ratio": "gear",
    "transmission_error": "gear",
    "lost_steps": "motor",
    "following_lag": "motor",
    "effort_gain": "motor",
    "joint_friction": "bearing",
    "viscous_friction": "bearing",
    "stribeck_friction": "bearing",
    "joint_compliance": "shaft",
    "resonance": "load",
    "inertia": "load",
    "payload": "load",
    "effort_offset": "load",
    "home_offset": "encoder",
    "encoder_error": "encoder",
    "sensor_latency": "encoder",
    "sensor_drift": "encoder",
}
"""Where on a lone axis an effect sits; anything else (and `unknown`) means all of it."""


def parts_of(effect: str, component: str) -> list[str]:
    """Names of the parts of a delta's drawing; empty for a component that is not on it."""
    stem, last = component[:-1], component[-1:]
    if stem in ("motor", "joint") and last in ARMS:
        return [_at_motor(effect, last)]
    if stem == "arm" and last in ARMS:
        return [f"forearm{last}" if effect == "forearm_length" else f"upper_arm{last}"]
    if component.startswith("range_") and last in AXES:
        return [f"sensor_{last}"]
    if component == "sensors" or effect == "frame_tilt":
        return [f"sensor_{axis}" for axis in AXES]
    if component == "joints":
        return [_at_motor(effect, arm) for arm in ARMS]
    if component == "arms":
        return [f"{rod}{arm}" for arm in ARMS for rod in ("upper_arm", "forearm")]
    return {"frame": ["base"], "platform": ["platform"]}.get(component, [])


def _at_motor(effect: str, arm: str) -> str:
    if effect in _GEAR or effect in _BEARING or effect == "joint_compliance":
        return f"gear{arm}"
    return f"motor{arm}"


def lone_parts_of(effect: str, component: str) -> list[str]:
    """The same for a lone axis or a lone sensor, where every component is `axis`."""
    if effect in _LONE:
        return [_LONE[effect]]
    return ["sensor"] if effect.startswith(("sensor_", "stale_")) else ["motor", "gear", "load"]


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
