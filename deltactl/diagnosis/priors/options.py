"""The numbers of priors: what a set must earn, and how large effects and tolerances usually are.

What belongs to one effect is with the effect (`EffectKind`). Every other room whose numbers
decide has such a table (`options.py` in `observations`, `admission`, `plants`, `plants.delta`,
`plants.lone`, `evidence`, `selection`, `assessment`, `experiment`, `pipelines` and `answer`).
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class PenaltyOptions:
    """What an explanation must earn, in chi-square, and what passes for a tolerance."""

    event: float = 10.0
    """A thing that happens once, beyond its size: about what one of a thousand moments costs (2 log
    1000 = 13.8), less two standard deviations."""
    group: float = 10.0
    """That three arms err alike is less likely than one other cause that looks the same."""
    in_name_only: float = 50.0
    """An effect that does not do what it is called after bends like any shape, and costs like one.
    """
    whole_travel: float = 0.97
    """Share of the travel from which on a period is one bend."""
    spline_factor: float = 4.0
    """So many times more than a named effect where another explanation may have left its shape: a
    spline term fits many things a little."""
    within: float = 2.0
    """Usual spreads within which an error is no fault by itself."""
    care: tuple[float, ...] = (1.0 / 60.0, 0.2, 1.0)
    """Shares of the usual tolerances that building may leave, of which the evidence decides,"""
    careless: float = -2.0
    """and the log odds of each but the first: most machines are built as their file says."""
    most_careful: float = 1.0 / 60.0
    """Share of the usual tolerances that the most careful building leaves: 0.025 mm at a sensor,
    0.01 mm in an arm, 0.03 mrad at a home."""


@dataclass(frozen=True, slots=True)
class SizePriorOptions:
    """The prior of sizes around what is typical of an effect."""

    known_to: float = 3.0
    """The factor to which its spread itself is known: answers say what changes within it."""


PENALTIES = PenaltyOptions()
SIZE_PRIORS = SizePriorOptions()
"""As the engine is used."""
