"""The numbers by which a test of one candidate counts."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ScoreTestOptions:
    """What may come about by chance, and what cannot be told from something else."""

    chance: float = 1e-5
    """Below which repeated readings are stale and the past of a covariate counts. Readings
    correlate, so well below the alarm."""
    edge: float = 0.02
    """Share of the recording at each end in which a loss cannot be told from an offset."""
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
    """Of a sinusoid in a recording; slower ones are seen by the splines over time."""


SCORE_TESTS = ScoreTestOptions()
"""As the engine is used."""
