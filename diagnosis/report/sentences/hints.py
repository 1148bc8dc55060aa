"""What distinguishes a finding from an alternative, one sentence for a pair of effects.

These are of deltas; a lone axis has its own table (`telling_apart`).
"""

from __future__ import annotations

from diagnosis.answer.records import Finding
from diagnosis.report.sentences.telling_apart import LONE, how

_HINTS: tuple[tuple[frozenset[str], str], ...] = (
    (
        frozenset({"gear_backlash", "joint_friction"}),
        "Standing still after approaching from both sides, another payload, or the motor "
        "current would distinguish play from friction.",
    ),
    (
        frozenset({"following_lag", "sensor_latency"}),
        "Recording the arm angles too would distinguish a late drive from late readings.",
    ),
    (
        frozenset({"home_offset", "forearm_length"}),
        "A run through more of the workspace would distinguish them better.",
    ),
    (
        frozenset({"home_offset", "sensor_offset"}),
        "A run with more tilted arms, or arm angles measured, would distinguish them.",
    ),
    (
        frozenset({"following_lag", "motor_azimuth"}),
        "The same path run the other way round would distinguish them.",
    ),
)
"""Pairs that are hard to distinguish, and what distinguishes them."""


def hint(finding: Finding) -> str:
    """What would distinguish a finding from its alternatives; empty where no line says."""
    others = [one.effect for one in finding.alternatives]
    if finding.component == LONE:
        ways = [way for other in others if (way := how(finding.effect, other))]
        return f"To tell them apart: {ways[0]}." if ways else ""
    effects = {finding.effect, *others}
    return next((hint for pair, hint in _HINTS if pair <= effects), "")
