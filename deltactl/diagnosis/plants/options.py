"""The numbers that machines of every kind share: spline terms, and what no effect explains."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class SplineTermOptions:
    """For shapes over one covariate, for model error that no named effect explains."""

    spline_degree: int = 3
    """Cubic: bends without corners, as speeds and forces have no jumps."""
    covered: tuple[float, float] = (0.002, 0.998)
    """Quantiles of a covariate between which the pieces lie: single wild values would stretch
    them over a range in which nothing was read."""
    vanishing: float = 3e-3
    """Share of the largest direction: one that is smaller occurs in no row; made as large as the
    others it would be a spike at one of them."""
    mostly: float = 0.5
    """Share of a direction's variance from which on it is the named shapes' own: more of it."""
    unknown_log_odds: float = -5.0
    """Log odds of a model error that no named effect makes: one machine in 150 has it, for each
    covariate (and place of a delta)."""
    uneven_map: float = 3.0
    """Times the even share of what repeats that a shape of a map in detail usually has."""


@dataclass(frozen=True, slots=True)
class UnknownOptions:
    """For a finding without a name."""

    places_in_table: int = 64
    """Places of the quantity that it follows: sixteen to each piece of a delta's spline, ten of an
    axis'; a map in detail has one to each piece."""


UNKNOWN = UnknownOptions()
SPLINE_TERMS = SplineTermOptions()
"""As the engine is used."""
