"""The numbers by which sets of regressors are believed."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class SelectionOptions:
    """Of the posterior over sets (lone machines); a delta's are `priors.options.SearchOptions`."""

    window: float = 12.0
    """Sets whose log evidence is further below the best's than this are not counted (e^-12)."""
    most_regressors: int = 7
    """In one set: more were never told apart in one recording."""
    pairs_up_to: int = 1
    """Regressors in a set up to which two more are added at once, as some show only together."""
    naming_rounds: int = 3
    """How often named effects are chosen under the noise that the last choice leaves."""
    sure: float = 0.95
    """Posterior above which a regressor is settled,"""
    open: float = 0.05
    """below which it is out of the question,"""
    likely: float = 0.5
    """and above which it is believed."""


SELECTION = SelectionOptions()
"""As the engine is used."""
