"""The numbers by which a recording is refused: each must be out of reach of a sound one."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class AdmissionOptions:
    """Shares are of how much the readings move unless something else is said."""

    # Any recording.
    fewest_in_all: int = 90
    """Valid readings of all channels together below which nothing can be learned."""
    stands_still: float = 1e-4
    """Travel [m or rad] below which nothing moves: a tenth of what a distance sensor resolves."""
    unit_factor: float = 20.0
    """Times the expected readings from which on the unit is wrong: inches for metres make 39 times,
    degrees for radians 57."""
    beyond_deg: float = 10.0
    """By how much step counts may pass the limits of the robot file: a stop lies beyond them, and
    homing goes there."""

    half_round_deg: float = 170.0
    """How far an arm may turn to either side where the robot file has no limits: half round, less
    what the base takes."""
    farthest_ranged_m: float = 300.0
    """Median distance that is doubted: radios and lasers for machines see a few hundred metres."""
    most_of_arms: float = 0.99
    """Share of the readings of an arm's angle that must lie within its limits: single readings go
    astray, a wrong unit is wrong everywhere."""
    times_s: tuple[float, float] = (2e-5, 15.0)
    """Between a single axis' samples: 50 000 a second are more than any drive logs, and steps of
    more than 15 s are milliseconds."""

    most_unassembled: float = 0.02
    """Share of the samples of a delta whose commands no linkage reaches: another robot's."""

    # How much of a long recording is looked at.
    delta_rows: int = 30_000
    """Ten minutes at 50 Hz: a search on two cores holds 1.1 GB then (`costs/diagnosis_cost.py`)."""
    fast_rows: int = 300_000
    """Rows of a servo's loop or a single axis or sensor, fewer of which are worked on than are
    read."""
    range_rows: int = 5_000_000
    """Rows of a distance sensor alone, which are gathered before anything else."""
    fewest_of_each: int = 600
    """Rows of each recording, where there are so many that each can have only a few."""

    # Whether the recording is of the machine in the file.
    looked_at: int = 500
    """Rows in which another machine is looked for, spread over the recording,"""
    fewest_looked_at: int = 50
    """and below which none is."""
    late_s: tuple[float, ...] = (0.0, 0.04, 0.08, 0.12, 0.16, 0.2, 0.25, 0.3, 0.4, 0.5)
    """Delays of a drive or of the sensors; a recording that is late belongs all the same."""
    nowhere_m: float = 1.0
    """Model error where the other machine cannot be assembled: more than any reading is off."""
    soft_from: float = 3.0
    """Standard deviations of the scatter from which on a reading counts less in that fit."""
    match_evaluations: int = 40
    """At which that fit ends: near enough to say whether any machine fits."""
    trimmed_fits: int = 5
    """So often the samples that fit best are chosen anew, from either start."""
    far_off: float = 0.15
    """A model error larger than this share needs an explanation."""
    near_scatters: float = 3.0
    """Standard deviations of the scatter within which a reading is where it should be."""
    near_share: float = 0.2
    """A machine that agrees with the file in this share of the time is the file's."""
    off: float = 0.05
    """No build of one machine errs by more of a length or of the gear than this."""
    trusted: float = 0.4
    """Share of the samples that the fit of another machine goes by: something may stop a machine
    for more than half of the time."""
    usual_share: float = 0.005
    """Spread of lengths and gear between builds; the nearest machine that fits is looked for."""
    usual_home_rad: float = 0.1
    """Spread of homes."""
    usual_offset_m: float = 0.05
    """Spread of what looks at the machine."""

    # Whether it broke while it was recorded.
    moments_tried: int = 100
    """Moments that may be the one, a hundredth of the recording apart."""
    least_before: int = 40
    """Readings that must agree before something broke."""
    least_after: float = 0.05
    """Share of the recording that must be left after it."""
    nearly_all: float = 0.9
    """Share of the readings, before and after; the others may be wherever they like."""
    broken_off: float = 0.2
    """After it the readings are off by more than this share."""
    worse: float = 1.9
    """And by so many times more than before."""
    least_moving: float = 0.3
    """It still moves by this share: a platform pressed on a stop that rests there is not broken."""
    still_agrees: float = 0.3
    """A machine agrees with the file where it is nearer than this share of what it is off later."""
    stray: float = 0.2
    """Share of the readings that may be far off before, or near after."""
    offsets: float = 0.25
    """Steps that were lost leave less than this share once the joints are shifted."""
    most_lost_rad: float = 0.5
    """Nor do they come to more than this: so far no motor falls behind and goes on as before."""

    exchanged: float = 0.5
    """Arm angles that fit the commands of other arms to within this share of what they fit their
    own: columns or motors are exchanged. Of 15 recordings of a delta whose drives are a tenth of a
    second late, those of other arms leave 1.6 to 4.4 times as much."""

    # Single axes and sensors.
    against: float = -0.5
    """Correlation with its command below which a reading runs against it."""
    ahead: float = 0.9
    """A reading that fits its command (with an offset and a ratio) so much better when that is
    taken earlier than it came leads it: columns are swapped, or the drive overshoots. Of 45
    recordings of other people's machines none comes below 1.003; two with the columns swapped come
    to 0.70 and 0.27."""
    most_ahead_s: float = 1.0
    """So far ahead is looked; a tenth of the recording where that is shorter."""
    shifts: int = 30
    """Times between one sample and that at which is looked, earlier and later."""
    hopeless: float = 0.5
    """Left over with the best explanation: columns or robot file are another machine's."""
    moves_alike: float = 0.9
    """Correlation from which on command and reading are one motion, whatever their sizes."""
    as_far: float = 1.2
    """A motion so much farther than another is reported as a factor; less is no mistyped number."""
    near_factor: float = 0.2
    """How near a ratio must be to a factor between units to be put down to it."""
    sure_of_mass: float = 8.0
    """Standard errors by which a mass must differ from the file's before a unit is blamed."""
    known_mass: float = 0.1
    """Standard error of a mass, as a share of it, with which a unit can be blamed."""
    correlated: float = 10.0
    """Rows that count as one in that standard error: they are a filter's length apart, and what
    is left is still correlated over several."""
    brakes: float = -0.5
    """Correlation of effort and velocity below which an effort brakes all the time: a drive that
    has friction to overcome pushes, and a weight helps as often as it hinders,"""
    least_each_way: float = 0.25
    """where the axis moves so large a share of the time either way."""
    least_against: float = -0.3
    """Times the file's inertia below which an axis accelerates against its effort."""


ADMISSION = AdmissionOptions()
"""As every recording is admitted."""
