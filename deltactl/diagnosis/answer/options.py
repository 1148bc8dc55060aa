"""The numbers of the verdict, for every kind of machine."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class VerdictOptions:
    """Levels at which the same figures lead to another verdict."""

    alarm: float = 0.003
    """Chance that a healthy machine is said to have something missing: one recording in three
    hundred, as rare as a result beyond three standard deviations. The one level of the engine: it
    is family-wise (all that is tested counts), and holds for the first alarm, for every further
    effect, and for what is left."""
    at_floor: float = 1.1
    """Times the noise floor up to which a residual is at the floor. The floor is an estimate: from
    50 independent readings it is known to 10 %."""
    faint_rest: float = 0.05
    """Share of the model error that may be left although a test sees it: the model is said to
    explain the recording, and the answer names what is left."""
    too_little: float = 0.01
    """Share of the model error (without a finding, of what the file's measured effects do) below
    which what is left calls for nothing: a tenth of the size that is explained, as drives and
    bearings differ from their models."""
    grew: float = 1.01
    """Times the held-out model error before, from which on it grew. Both are of the same readings,
    so noise cancels; findings that do not come back (lost steps) move it by less than this."""
    beyond_rest: float = 3.0
    """Times the scatter of readings at one place from which on what is left is not called their
    noise: a noise with a memory hardly changes within a stay, and shows less than its size."""
    half_of_power: float = 0.7
    """Half of a power, in size. A residual with this correlation from reading to reading is not
    called the noise of a sensor. Effects of the file account for a residual if they may leave this
    share of it, and scatter at one place for the noise floor if it has this share of it."""
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
    least_steps: float = 1.0
    """A motor loses whole steps; less than one microstep is none."""


VERDICT = VerdictOptions()
"""As every answer is made."""


@dataclass(frozen=True, slots=True)
class SayingOptions:
    """What decides which steps and reservations the same figures call for."""

    settled_p: float = 0.95
    """A finding more probable than this is not called open, whatever its alternatives."""
    fewest_moved: float = 1.0 / 3.0
    """Share of the rests in which an axis must have moved to count as moving."""
    moved_of_left: float = 2.0
    """Times what is left, by which it must have: one glide in hours is none."""
    mostly_left: float = 0.5
    """Share of the model error that nothing explains, from which on the columns and the robot file
    are to be checked first."""
    table_helps: float = 1.1
    """Times the model error that is left, below which without a table it would be as good."""
    minor_share: float = 0.01
    """Share of the model error: what does less is reported last, and needs no table."""
    by_the_loop: float = 2.0
    """Times the smaller part of a delay from which on the same is the larger in a drive of another
    order: of real servos fitted with one time constant and with two, none then changes sides. A
    part that may be smaller by this factor is not known."""
    much_of_delay: float = 0.5
    """Share of a delay from which on a loop that rings may well be all that is late."""
    same_period: float = 0.03
    """How far a period may be from a whole fraction of another: what intervals of both amount
    to."""
    disagrees: float = 0.01
    """Chance below which recordings are said to disagree."""


SAYING = SayingOptions()
"""As every answer is put into words."""
