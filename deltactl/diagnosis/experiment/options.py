"""The numbers by which the next run is designed."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ExperimentOptions:
    """What a run must tell, and how long it may take."""

    settles: float = 40.0
    """Expected chi-square that a run must give: it then leaves less than the limit of a tie (11)
    once in a hundred times, as chi-square scatters by twice its root."""
    holds_back: float = 1.5
    """Evidence aimed at over `settles`: the machine is never quite what the model says."""
    longest_min: float = 8.0
    """A tie that needs a longer run is left open."""
    shortest_min: float = 1.0
    """Repeated up to this: homing and starting take as long as a shorter run."""
    most_ties: int = 4
    """Ties that one run is designed for, the closest first: each is simulated both ways."""
    refined: int = 2
    """Runs whose evidence is worked out again with everything else refitted to the end."""


EXPERIMENT = ExperimentOptions()
"""As the engine is used."""
