"""The numbers of the verdict, for every kind of machine."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class VerdictOptions:
    """Levels at which the same figures lead to another verdict."""

    alarm: float = 0.003
    """Chance that a sound machine is said to have something missing: one recording in three
    hundred, as rare as a result beyond three standard deviations. The one level of the engine: it
    is family-wise (all that is tested counts), and holds for the first alarm, for every further
    effect, and for what is left."""
    at_floor: float = 1.1
    """Times the noise floor up to which a residual is at the floor. The floor is an estimate: from
    50 independent readings it is known to 10 %."""
    faint_rest: float = 0.05
    """Share of the mismatch that may be left although a test sees it: the model is said to explain
    the recording, and the answer names what is left."""
    too_little: float = 0.01
    """Share of the mismatch (without a finding, of what the file's measured effects do) below which
    what is left calls for nothing: a tenth of the size that is explained, as drives and bearings
    differ from their models."""
    grew: float = 1.01
    """Times the held-out mismatch before, from which on it grew. Both are of the same readings, so
    noise cancels; findings that do not come back (lost steps) move it by less than this."""
    beyond_rest: float = 3.0
    """Times the scatter of readings at one place from which on what is left is not called their
    noise: a noise with a memory hardly changes within a stay, and shows less than its size."""
    goes_on: float = 0.7
    """Correlation of what is left from one reading to the next from which on it is not called the
    noise of a sensor: half of its power can then be told from the reading before."""
    most_of_rest: float = 0.7
    """Of the size of what is left, from which on what effects of the file may leave is half of its
    power."""
    even: float = 0.5
    """Posterior of the empty set below which nobody may say that nothing is missing."""
    sure_enough: float = 0.8
    """A finding less probable than this is written into the corrected robot file only when
    everything is asked for."""
    as_well: float = 1.0
    """Chi-square by which an alternative may be worse and still fit as well: what one size more or
    less makes by chance."""
    outweighed: float = 4.0
    """Times as probable as a name that something unknown must be for the name to count as a part of
    it: four to one, as `sure_enough`."""
    least_seen: float = 1e-9
    """Share of the residual that a test explains at least when it finds more than noise in it."""
    rounding: float = 1e-9
    """Of shares and probabilities that are added up: far above what sixteen digits lose."""
    least_steps: float = 1.0
    """A motor loses whole steps; less than one microstep is none."""


VERDICT = VerdictOptions()
"""As every answer is made."""
