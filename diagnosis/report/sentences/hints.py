"""What distinguishes a finding from an alternative, one sentence for a pair of effects."""

from __future__ import annotations

from diagnosis.answer.records import Finding

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
    effects = {finding.effect, *(one.effect for one in finding.alternatives)}
    return next((hint for pair, hint in _HINTS if pair <= effects), "")
