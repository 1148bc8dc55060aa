"""The numbers by which a posterior over sets of regressors becomes an answer."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class RegressionOptions:
    """For single axes and sensors and for the joints of a servo delta."""

    posterior_draws: int = 2000
    """Draws of the sizes: the ends of a 95 % interval are then known to a few per cent."""
    least_probability: float = 0.02
    """Alternatives less probable than this get no line."""
    of_a_row: float = 0.25
    """Part of the time between two rows to which what was commanded between them is known."""
    as_good_as_none_s: float = 5e-4
    """Standard deviation below which no time constant is known: a drive has one, and its model and
    the clock are off by as much."""
    fewest_places: int = 5
    """Places at which a sensor was read, before their scatter is separated from what is alike at
    one."""
    fewest_stays: int = 20
    """Readings in all rests of an axis beyond their means: they tell the scatter to a sixth."""
    same_load: float = 0.01
    """Share of the load's range by which it may change from row to row and be one load."""
    memories_a_stay: float = 3.0
    """Autocorrelation times that a rest lasts at least: noise hardly changes within one."""


REGRESSION = RegressionOptions()
"""As the engine is used."""
