"""The numbers by which recordings become readings, and by which foreign tables are understood."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ObservationOptions:
    """Of readings, motions and inputs; what is refused later stands in `admission.options`."""

    # Rows and their times.
    fewest_samples: int = 30
    """Rows below which nothing is told of a recording: a dozen sizes with their noise."""
    between_recordings_s: float = 60.0
    """Put between recordings that are laid end to end. How long the machine really paused is not
    known; nothing but its warmth lasts as long."""
    furthest_own_s: float = 0.5
    """A range's own time further from that of its row is no time of that row."""
    travel: tuple[float, float] = (0.02, 0.98)
    """Quantiles between which a column's travel is read: a few wild readings do not stretch it."""

    # Readings that are a number held or rounded.
    near_step: float = 0.1
    """Of a step: a reading so near to a whole multiple counts as one. Of any numbers one in five
    is."""
    most_on_step: float = 0.95
    """Share of the readings that must be multiples for the step to be that of an encoder."""
    same_step: float = 1.5
    """Times the smallest distance between readings up to which distances are one and the same step:
    two steps would be twice as much."""
    held: tuple[float, float] = (0.45, 0.95)
    """Shares of rows that repeat the one before, between which a sensor may have been read faster
    than it measures: twice as fast repeats half. Beyond the second it hardly ever moves."""
    evenly_held: float = 0.9
    """Share of the repeats that must be equally long, to one row, for that."""

    # Readings that are none.
    hampel_rows: int = 11
    """Readings of which the median is a reading's neighbourhood: up to five in a row stand out."""
    hampel_limit: float = 6.0
    """Robust standard deviations from it beyond which a reading does not count: noise goes there
    once in five hundred million readings, and the median itself scatters little."""
    gross_rows: int = 7
    """The same before anything is known of the machine: up to three in a row stand out."""
    gross_factor: float = 30.0
    """Times the usual distance from its neighbours at which a reading is grossly off."""
    gross_quantile: float = 0.9
    """Of all such distances, the one that counts as usual: motion makes the largest of them."""
    gross_share: float = 0.25
    """A reading is not gross that lies nearer to its neighbours than this share of the travel."""
    most_gross_share: float = 0.05
    """Where more readings than this are off, they are how the machine moves."""

    # Inputs.
    least_known: float = 0.5
    """Share of the rows that must hold an input; the holes are bridged."""
    largest_ratio: float = 50.0
    """Between motions asked for and seen, beyond which it is their units: degrees for radians make
    57 times. Gears and scales that are off make a few per cent."""

    # Velocity and acceleration from positions.
    uneven: float = 0.02
    """Share of the sampling period by which a sample may come early or late before readings are put
    onto an even grid to be filtered: left as they are, samples 10 and 12 ms apart in turn made the
    acceleration of a robot's joint thirteen times as large."""
    low_pass_order: int = 4
    """Of the Butterworth filter, run both ways so that nothing is delayed."""
    above_noise: float = 10.0
    """Times its noise floor that a spectrum stands above where it still tells of motion. Noise with
    memory (0.7 from sample to sample) has slow parts 6 times its fast ones."""
    spectrum_band_hz: float = 0.3
    """Over which the spectrum is averaged, so that no single line of noise stands above."""
    cut_off_hz: tuple[float, float] = (0.5, 15.0)
    """Lowest and highest end of the low-pass: moves of a joint last less than two seconds, and
    above 15 Hz its structure rings, which no rigid body does."""
    cut_off_of_rate: float = 0.2
    """Highest end as a share of the sampling rate: five samples a period tell an acceleration."""
    highest_of_nyquist: float = 0.9
    """Of half the sampling rate, beyond which the filter cannot be built soundly."""
    edge_periods: float = 1.0
    """Periods of the low-pass at each end of a stretch in which it still remembers that end,"""
    edge_rows: int = 5
    """and the rows that it is at least."""
    fewest_in_stretch: int = 40
    """Rows below which a stretch is not filtered, and does not count."""
    edges_in_stretch: int = 3
    """Nor does one that is not so many times as long as what is left out at its end."""
    top_speed_quantile: float = 0.98
    """Of all speeds, the one that counts as the highest: noise makes the largest."""

    # A servo delta, read at the rate of its drives.
    servo_period_s: tuple[float, float] = (1e-4, 0.1)
    """Between samples: drives close their loops no faster, and slower rows show no acceleration."""
    least_turn_rad: float = 1e-3
    """Travel below which the joints stand still: one count of a coarse encoder."""
    means_s: float = 0.01
    """Over which disturbances are averaged: an observer's estimate at full rate carries each step
    of the encoder."""
    smoothing_s: float = 0.04
    """Length of the polynomials that give speed and acceleration."""
    smoothing_degree: int = 3
    """Of these polynomials: the acceleration may change within one."""
    at_rest: float = 6.0
    """Standard deviations of the speed within which a joint may stand: friction may then be
    anything up to its size, and the sample says nothing."""
    slowest_joint: float = 0.01
    """The same as a share of the highest speed."""
    dithered: float = 0.3
    """Encoder counts per time constant of the observer below which each step makes the drive
    twitch: the arm goes to and fro in between, and friction does not brake its whole size."""
    around_rest_s: float = 0.02
    """Left out on either side of such samples: half the length of a polynomial sees them."""
    least_usable: float = 0.05
    """Share of the samples in which a joint must move faster than that."""


@dataclass(frozen=True, slots=True)
class GuessOptions:
    """Of a table that says neither what its columns are nor their units; `--inspect` shows each
    guess and the command that says otherwise."""

    # Which column is what.
    guessed_rows: int = 20_000
    """First rows that are looked at: what a column is shows in minutes."""
    least_filled: float = 0.5
    """Share of its rows that a column must hold to be anything."""
    fewest_in_common: int = 10
    """Rows that two columns must both hold to be compared."""
    alike: float = 0.8
    """Correlation from which two columns are one motion, asked for and seen."""
    alike_slope: float = 0.95
    """Correlation with the slope of another from which a column is its velocity."""
    slope_rows: tuple[int, ...] = (1, 3, 10, 30, 100)
    """Over so many rows the motion is compared: over few the noise of the position rules, over many
    the drift of the velocity."""
    longest_lead: int = 40
    """Rows by which what was asked for may be ahead of what was seen: 0.8 s at 50 Hz."""
    large_count: float = 200.0
    """Travel beyond which whole numbers are step counts rather than labels or states."""
    mostly_still: float = 0.1
    """Share of its rows in which a column that stands still in turns changes at most."""
    most_runs: float = 0.02
    """Times that a clock may start again, as a share of the rows: runs shorter than fifty rows are
    none."""

    # Units.
    ticks_ns: tuple[float, float] = (1e5, 2e5)
    """Whole steps of time from the first on are ticks of a computer's clock; from the second on in
    nanoseconds (0.2 ms), below it in microseconds."""
    ticks_us: float = 1000.0
    """The same in microseconds: 1 ms and more,"""
    ticks_ms: float = 1.0
    """and in milliseconds."""
    longest_step_s: float = 20.0
    """Steps of time that are larger are milliseconds, whole or not."""
    near_unit: float = 0.15
    """How near the ratio of two travels must be to a factor between units to be put down to it."""
    other_unit: float = 1.5
    """Times d(position)/dt from which a velocity has another unit: filters make a few per cent."""
    widest_rad: float = 13.0
    """Two turns: more is degrees, millimetres or counts far more often than radians or metres."""
    said_factor: float = 4.0
    """Times that, before radians that somebody stated are doubted."""
    narrowest_deg: float = 0.5
    """Degrees that somebody stated are doubted where all stay below: 30 degrees are 0.52 rad."""
    least_counts: float = 400.0
    """Whole numbers up to more than this are encoder counts rather than degrees, which end at a
    turn."""
    count_rad: float = 0.001534
    """One of 4096 counts a turn, as hobby servos have: the one that is most often met."""
    few_turns_deg: float = 1440.0
    """Of an axis without a unit: more is seconds of arc or counts rather than degrees or mm."""
    longest_m: float = 15.0
    """More is millimetres: no ranging sensor of this kind sees so far, and no axis is so long."""

    # What the times and zeros are like.
    large_jitter: float = 0.2
    """Standard deviation of the steps of time, as a share of the usual one, beyond which the
    stamps are those of whoever logged."""
    zeros_apart: float = 0.25
    """Part of the whole motion by which command and reading lie apart where their zeros differ."""


OBSERVATIONS = ObservationOptions()
GUESSES = GuessOptions()
"""As every recording is read."""
