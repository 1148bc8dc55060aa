"""Probabilities in percent."""

from __future__ import annotations

CERTAIN = 0.995
"""A probability that would be rounded to all or nothing is said to lie above or below one percent
of it: no engine knows its own mistakes better."""


def percent(probability: float) -> str:
    """A probability in percent, never 0 or 100."""
    if probability >= CERTAIN:
        return "above 99 %"
    return "below 1 %" if negligible(probability) else f"{100.0 * probability:.0f} %"


def negligible(probability: float | None) -> bool:
    """Whether it rounds to less than one percent."""
    return probability is not None and probability < 1.0 - CERTAIN
