"""The numbers by which sets of regressors are accepted."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class SelectionOptions:
    """For the posterior over sets."""

    window: float = 12.0
    """Sets whose log evidence is further below the best's than this are not counted (e^-12)."""
    most_regressors: int = 7
    """At one component in one set: more were never distinguished in one recording."""
    pairs_up_to: int = 1
    """Regressors in a set up to which two more are added at once, as some show only together."""
    naming_rounds: int = 3
    """How often named effects are chosen under the noise that the last choice leaves."""
    sure: float = 0.95
    """Posterior above which a regressor is settled,"""
    open: float = 0.2
    """below which it is out of the question: a row more or less does not have it chosen,"""
    likely: float = 0.5
    """and above which it is accepted."""
    most_of_map: float = 0.5
    """Share of what repeats with the position that a wave must make up to be named beside a map:
    of a rough surface the largest wave has a tenth to a third, of a gear nearly all."""
    most_points: int = 5
    """Points near which effects are chosen, where the model is linear only near one."""
    many_names: int = 4
    """Names in a set from which on what has no name is tried in the place of all of them,"""
    careless_names: int = 2
    """and from which on a machine may be one that was built with less care."""
    better_by: float = 1e-6
    """Log evidence that a move must add: less is rounding."""
    nearly_best: float = 2.0
    """Sets behind the best by less in log evidence are tried without each of their regressors."""


@dataclass(frozen=True, slots=True)
class CredibleOptions:
    """For what the search for a delta's effects compared around the set it chose."""

    lapse: float = 0.02
    """Chance that the search ended at a wrong set and nothing it compared around that shows it. Of
    111 claims that the comparison alone made with more than 0.95, on proof cases of two old seeds,
    three were wrong."""
    beside_in_place: float = 0.05
    """Chance that a name is a cause of its own in the place of an unknown: of 16 such claims in 105
    proof cases of seed 27182818, none was true."""


SELECTION = SelectionOptions()
CREDIBLE = CredibleOptions()
"""As the engine is used."""
