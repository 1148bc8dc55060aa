"""The numbers by which a test of one candidate counts."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ScoreTestOptions:
    """What may come about by chance, and what cannot be distinguished from something else."""

    chance: float = 1e-5
    """Below which repeated readings are stale and the past of a covariate counts. Readings
    correlate, so well below the alarm."""
    least_own: float = 0.02
    """Share of a jump that what is fitted already must leave for its time to be tried."""
    near_s: float = 2.0
    """How far from where it was found the moment of a jump may lie once all else is fitted."""
    fewest_repeats: int = 10
    """Readings alike in a row, below which nobody counts: a fifth of a second at 50 Hz."""
    many: int = 3
    """From so many runs on the value they hold is asked for: one value again and again is the end
    of a range, not an old reading."""
    least_share: float = 0.05
    """What the past must explain of what the present does; less is a shape that is not quite right.
    """
    fewest_turns: float = 6.0
    """Turns of a sinusoid in a recording; slower ones are covered by the splines over time."""
    draws: int = 1000
    """Draws of pure noise, by which the smallest p of all tests is calibrated."""
    seed: int = 20260101
    """The same draws each time, so that the same recording has the same answer."""
    least_change: float = 1e-9
    """m or rad: an effect that at its usual reach changes every channel by less does not show."""
    collinear_scores: float = 1e-6
    """Share of a column that must be left after projection for a test to be possible."""
    past_s: tuple[float, ...] = (0.06, 0.3, 1.5)
    """How long before a reading the past is looked at: three readings at 50 Hz, and five and 25
    times that."""
    fastest: float = 0.2
    """Turns of a sinusoid a sample, at most."""
    finer: int = 4
    """Frequencies looked at, for each that the length of the recording resolves."""
    between: int = 16
    """Frequencies tried on either side of the strongest."""
    most_transformed: int = 2**18
    """Samples of the stretches in which the frequency is looked for: an hour and a half at 50 Hz.
    Stretches of a day keep no phase with each other."""


SCORE_TESTS = ScoreTestOptions()
"""As the engine is used."""
