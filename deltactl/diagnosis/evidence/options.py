"""The numbers by which the noise is estimated and evidence is counted."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class EvidenceOptions:
    """For the saturated fit, what it takes from the noise, and the effective sample size."""

    # Autoregression.
    ar_order: int = 2
    """Its order: enough for a filter or a mean of neighbours. More is hardly distinct from a model
    error."""
    huber: float = 2.5
    """Standard deviations from which on a reading counts less: of normal noise one in eighty."""
    longest_hole: int = 5
    """Samples missing in a row over which the autoregression continues."""

    # The noise of a machine whose effects are fitted together.
    noise_rounds: int = 2
    """The first is whitened by a noise that still has the whole model error in it."""
    ridge: float = 1e-5
    """Ridge of the library's scaled normal equations, whose columns are nearly collinear: small
    beside the part of a column that is its own."""
    readings_a_column: int = 4
    """Fewest readings for each direction that is fitted, so that three in four are left to see the
    noise by."""

    tolerated: float = 2.0
    """Standard deviations of what is off on any machine as built, beyond which it is a finding:
    machines within them are 95 %."""

    # The noise of a machine whose model error is a sum of known columns.
    tempering_rounds: int = 3
    """The first fit takes the whole model error for noise, each further one what the last fit
    left."""
    digits: float = 1e-6
    """No likelihood is trusted to this share of the readings: few tables have more digits."""
    spike_limit: float = 4.0
    """Robust standard deviations off its neighbours from which on a reading counts less. Higher
    than usual for Huber's weights: what a saturated model leaves is not quite noise."""
    spike_share: float = 0.2
    spike_quantile: float = 0.9
    """A robust standard deviation is at least this share of this quantile of all such distances:
    rounded readings that hardly move have none otherwise."""
    leap: float = 0.1
    """Share of the travel in one sample that is a leap: what rests through it is late."""
    spike_weight: float = 0.75
    """A reading whose weight is larger keeps all of it."""
    clipped_at: float = 4.0
    """Standard deviations to which the residual is cut before its memory is measured."""
    most_taken: float = 0.6
    """Share of the effective readings that a fit's sizes may count for in the noise's variance."""
    fewest_effective: float = 6.0
    """Independent readings that any recording is taken for, however long its memory."""
    most_given_back: float = 2.5
    """Times the variance of a residual beyond which it says nothing of the noise."""
    unsampled_rounds: int = 5
    """Until the noise of readings settles beside what the command does between samples."""

    # What spline terms take out of noise with a memory.
    correlations: tuple[float, ...] = (0.0, 0.3, 0.5, 0.7, 0.8, 0.87, 0.92, 0.95, 0.97)
    """Correlations of neighbours for which the fit is tried; beyond the last the last is taken."""
    simulated_noises: int = 12
    """Draws for each of them."""
    uncorrelated: float = 0.05
    """The autocorrelation is summed to where it first falls below this."""

    # What comes back each time an axis passes a place.
    fewest_repeated: int = 200
    """Readings below which a map in detail has too few to a cell."""
    coarsest_cells: int = 24
    """Cells of the travel; twice as many as long as readings are left for them. Coarser ones are
    what spline terms have anyway."""
    rows_a_cell: float = 3.0
    """Readings to each of the finest cells."""
    fewest_visits: int = 2
    """To a cell, at different times,"""
    share_visited: float = 0.7
    """in at least this share of the cells."""
    repeat_shifts: int = 200
    """In time against the places, by which it is seen what chance comes to."""
    repeats_at_sigma: float = 6.0
    """Robust standard deviations of those beyond which it is none: their tails are heavier than a
    normal distribution's, as few visits make a mean."""
    least_repeated: float = 0.05
    """Share of the residual's variance below which a map would not change the fit."""
    most_of_repeats: float = 0.95
    """Share of the largest size: the coarsest cells that show as much are fine enough."""

    # The fit of one set of regressors.
    starts_kept: int = 4
    """Starts of a set that go on while its regressors join one after another."""
    targets_kept: int = 8
    """Model errors, by predictions of what is not linear, whose scalar products are kept."""
    most_fit_steps: int = 14
    """Gauss-Newton steps at which a fit is given up; it ends earlier by `fit_gain`."""
    fit_gain: float = 0.02
    """A step that gains less in chi-square ends a fit: far below what decides anything."""


EVIDENCE = EvidenceOptions()
"""As the engine is used."""
