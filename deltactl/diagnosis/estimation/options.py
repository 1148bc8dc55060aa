"""The numbers of fits, splines, noise models and change points, and what the search may take."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class EstimationOptions:
    """Chi-squares throughout where no unit is given."""

    # Noise.
    ar_order: int = 2
    """Order of its autoregression: enough for a filter or a mean of neighbours. More is hardly
    distinct from a model error."""
    huber: float = 2.5
    """Standard deviations from which on a reading counts less: of normal noise one in eighty."""
    longest_hole: int = 5
    """Samples missing in a row over which the autoregression is still carried."""
    warm_up: int = 200
    """Samples after which a draw has forgotten how it began."""

    # Fits.

    # Splines.
    pieces: int = 4
    """Pieces of a spline term: a shape with a few bends, seven coefficients."""
    least_move: float = 0.02
    """Share of its range that a covariate must move before it counts as having come another way."""

    # Change points.
    moments: tuple[int, ...] = (1, 2, 4, 8, 16, 32, 64, 128, 256)
    """Readings by which the time of an event is moved either way, to see whether that fits better.
    """

    edge: float = 0.02
    """Share of the recording at each end in which a loss cannot be distinguished from an offset."""

    # The limit of work: the unit is one prediction of a recording of 12 000 rows.


ESTIMATION = EstimationOptions()
"""As the engine is used."""
