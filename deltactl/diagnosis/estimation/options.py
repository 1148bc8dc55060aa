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
    block_s: float = 1.5
    """Blocks of time by which scores are compared: far longer than noise remembers, far shorter
    than a recording."""
    fewest_in_block: int = 30
    """Readings; blocks of slow recordings are longer."""

    # Fits.
    fit_steps: int = 6
    """Levenberg-Marquardt steps of a fit that is compared with others."""
    steps_to_the_end: int = 60
    """Those of the fit that the answer gives, which ends where a step gains little."""
    close_enough: float = 0.02
    """A step that lowers the cost by less than this ends the fit."""
    little_gain: float = 2.0
    """After one that lowers it by less than this the tangent may stay as it is,"""
    straight: float = 0.1
    """or after one that lowers it by what the tangent promised but for this share."""
    many_columns: int = 12
    """From so many on derivatives are worked out side by side: a fork costs as much as four."""
    retimed: int = 3
    """Fits of so many steps also move the change points of events."""
    collinear: float = 1e-10
    """Share of the largest eigenvalue below which columns count as one."""
    standing_out: float = 1e-6
    """Share of a column that must differ from the others for it to count."""

    # Splines.
    pieces: int = 4
    """Pieces of a spline term: a shape with a few bends, seven coefficients."""
    fine_pieces: int = 28
    """Pieces of one in the saturated fit, which must follow whatever is wrong."""
    least_travel: float = 0.005
    """Share of its size by which a covariate must vary; less is a ripple."""
    least_move: float = 0.02
    """Share of its range that a covariate must move before it counts as having come another way."""

    # Change points.
    moments: tuple[int, ...] = (1, 2, 4, 8, 16, 32, 64, 128, 256)
    """Readings by which the time of an event is moved either way, to see whether that fits better.
    """

    edge: float = 0.02
    """Share of the recording at each end in which a loss cannot be distinguished from an offset."""

    # The limit of work: the unit is one prediction of a recording of 12 000 rows.
    predictions: float = 1000.0
    """So many, and what else they need, take a core about nine seconds
    (benchmarks/costs/diagnosis_cost.py)."""
    rows_of_unit: int = 12_000
    """240 s at 50 Hz. A shorter recording allows more predictions in the same time."""
    noise_work: float = 200.0
    """The noise, when it is estimated once more, takes as long as so many predictions."""
    products: float = 1000.0
    """Products of two columns of derivatives that take as long as one prediction."""


ESTIMATION = EstimationOptions()
"""As the engine is used."""
