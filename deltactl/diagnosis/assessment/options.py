"""The numbers by which a chosen explanation is judged."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class AssessmentOptions:
    """Held-out blocks, detection limits, significance and intervals."""

    blocks: int = 20
    """Short stretches of a table sorted by distance, of which the folds take every fifth."""
    folds: int = 5
    """Blocks of a single axis' rows, each held out in turn."""
    moves: float = 2.5
    """Times the variance of its noise from which on a size moves with the block: five blocks tell a
    variance to a factor of two."""
    starts: float = 3.0
    """Independent tests that a regressor counts for which was searched at no moment or period."""
    unlikely: float = 0.05
    """Chance of a gain by luck up to which an effect is claimed where the evidence, too, leaves
    'nothing is missing' less than the alarm's level: by itself a level for a single question."""
    foretold: float = 0.5
    """Share of the model error of blocks left out: less than this left says more than the test,
    where the evidence, too, is that sure."""
    share_of_axis: float = 0.2
    """Share of a finding's power that a channel must show to be named with it."""
    carried_pieces: int = 6
    """Pieces of the spline by which an unknown of one run is carried to another."""
    places_to_begin: int = 9
    """Places in a play at which a held-out run may begin: an eighth of it is next to nothing."""
    found_at_sigma: float = 4.2
    """Standard deviations of a size at which the alarm is raised in four recordings of five: 3.3
    to overcome its Occam factor and its odds, 0.84 for the power. Reckoned, not counted."""
    of_a_second_size: float = 3.2
    """By how many it is more, in quadrature, where a second size has to be found as well (dead time
    beside a time constant, where in its play an axis begins). Counted on sixty simulated axes."""
    secant_rounds: int = 4
    """In which a detection limit is found where its effect is not linear: each is nearer by far
    more than a limit is known to."""
    fewest_at_rest: int = 5
    """Rows of a rest, and of all motion, that tell how much is left there."""
    settling_share: float = 0.33
    """First part of each rest, in which a drive may still arrive."""
    moved_sigma: float = 8.0
    """Standard deviations of the noise from one reading to the next by which an axis has moved: a
    thousand readings scatter over 6.5."""
    moved_steps: float = 3.0
    """The same in steps of the reading."""
    matters: float = 0.1
    """Change of a probability under other prior spreads from which on the answer says so."""
    clearly_off: float = 3.0
    """Standard deviations from which on the size of a build tolerance is reported: of the twenty
    that are fitted, one is two off by chance."""
    fewest_readings: int = 50
    """Readings of a channel below which no correlation is reported: 50 show it to 0.14."""
    apart_periods: float = 5.0
    """Readings further apart than so many periods are no neighbours."""


ASSESSMENT = AssessmentOptions()
"""As the engine is used."""
