"""The numbers by which recordings become readings."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ObservationOptions:
    """For readings, motions and inputs; limits of what is refused are in `admission.options`."""

    # Rows and their times.
    fewest_samples: int = 30
    """Rows below which nothing is learned from a recording: a dozen sizes with their noise."""
    between_recordings_s: float = 60.0
    """Put between recordings that are laid end to end. How long the machine really paused is not
    known; nothing but its warmth lasts as long."""
    furthest_own_s: float = 0.5
    """A range's own time further from that of its row is no time of that row."""

    # Readings that are a number held.
    held: tuple[float, float] = (0.45, 0.95)
    """Shares of rows that repeat the one before, between which a sensor may have been read faster
    than it measures: twice as fast repeats half. Beyond the second it hardly ever moves."""
    evenly_held: float = 0.9
    """Share of the repeats that must be equally long, to one row, for that."""
    single_step: float = 1.5
    """Steps of a reading: a smaller change is one step."""

    # Readings that are none.
    hampel_rows: int = 11
    """Readings of which the median is a reading's neighbourhood: up to five outliers in a row."""
    hampel_limit: float = 6.0
    """Robust standard deviations from it beyond which a reading does not count: noise goes there
    once in five hundred million readings, and the median itself scatters little."""
    most_outliers: float = 0.05
    """If more readings of a channel than this are outliers, that is the model error and not what a
    sensor does: a delta that rests between moves had 15 to 45 % of them, all while it moved. Of
    readings with noise alone it is 0.2 %."""
    neighbours: int = 7
    """The same before anything is known of the machine, and of what a saturated set leaves: up to
    three outliers in a row."""
    gross_factor: float = 30.0
    """Times the usual distance from its neighbours at which a reading is grossly off."""
    gross_quantile: float = 0.9
    """Quantile of all such distances that counts as usual: motion makes the largest of them."""
    gross_share: float = 0.25
    """A reading is not gross that lies nearer to its neighbours than this share of the travel."""
    most_gross_share: float = 0.05
    """Where more readings than this are off, they are how the machine moves."""

    # How a stretch begins.
    settles_s: float = 0.3
    """From its beginning until a drive is where its commands have it: three lags of a tenth of a
    second, which is a hobby servo's."""
    moving_share: float = 0.05
    """Share of the top speed above which a step is motion."""
    most_begun: float = 0.3
    """Share of a recording that is not left out for that: a log of short stretches has no more."""

    most_spikes: float = 0.005
    """Share of the readings that may be spikes: single ones beyond both of their neighbours,"""
    spike_factor: float = 8.0
    """by so many times as the next one is: turning points are many, and alike,"""
    spike_of_travel: float = 0.01
    """and by this share of the travel at least: below, rounding makes one reading an outlier."""

    # Inputs.
    least_known: float = 0.5
    """Share of the rows that must hold an input; the holes are bridged."""
    largest_ratio: float = 50.0
    """Between motions asked for and seen, beyond which it is their units: degrees for radians make
    57 times. Gears and scales that are off make a few per cent."""
    near_unit: float = 0.15
    """How near such a ratio must be to a factor between units for that unit to be proposed."""

    # Velocity and acceleration from positions.
    uneven: float = 0.02
    """Share of the sampling period by which a sample may come early or late before readings are put
    onto an even grid to be filtered: left as they are, samples 10 and 12 ms apart in turn made the
    acceleration of a robot's joint thirteen times as large."""
    low_pass_order: int = 4
    """Order of the Butterworth filter, run both ways so that nothing is delayed."""
    turning_wider: float = 4.0
    """Times the low-pass' frequency up to which the velocity that friction follows goes: at 5,
    noise makes needless names beside gross friction (even seeds 72000 ff.)."""
    above_noise: float = 10.0
    """Times its noise floor that a spectrum exceeds where it still shows motion. Noise with
    memory (0.7 from sample to sample) has slow parts 6 times its fast ones."""
    spectrum_band_hz: float = 0.3
    """Over which the spectrum is averaged, so that no single line of noise exceeds it."""
    cut_off_hz: tuple[float, float] = (0.5, 15.0)
    """Lowest and highest end of the low-pass: moves of a joint last less than two seconds, and
    above 15 Hz its structure rings, which no rigid body does."""
    cut_off_of_rate: float = 0.2
    """Highest end as a share of the sampling rate: five samples a period tell an acceleration."""
    highest_of_nyquist: float = 0.9
    """Share of half the sampling rate beyond which the filter cannot be built soundly."""
    edge_periods: float = 1.0
    """Periods of the low-pass at each end of a stretch in which it still remembers that end,"""
    edge_rows: int = 5
    """and the rows that it is at least."""
    fewest_in_stretch: int = 40
    """Rows below which a stretch is not filtered, and does not count."""
    edges_in_stretch: int = 3
    """Nor does one that is not so many times as long as what is left out at its end."""
    top_speed_quantile: float = 0.98
    """Quantile of all speeds that counts as the highest: noise makes the largest."""

    # The largest noise that spectra allow.
    noise_memories: tuple[float, ...] = (0.0, 0.5, 0.8, 0.9)
    """Correlation of neighbours in the noises that are mixed."""
    noise_levels: tuple[float, ...] = (0.003, 1e-4, 1e-6, 1e-9, 1e-12)
    """Chances between which that of a residual is reported; the first is the alarm's."""
    shortest_segment: int = 16
    longest_plain_segment: int = 128
    """Readings of a segment: where the longest memory is ten readings, 128 resolve its bend."""
    longest_segment: int = 4096
    bins_in_band: float = 10.0
    """Bins that resolve the band of a motion,"""
    fewest_bins: int = 4
    """and fewest in any band that is looked at."""
    fewest_segments: int = 3
    readings_of_segments: int = 5
    """Segments that a recording is cut into at least, where it can be."""
    least_of_segment: float = 0.3
    """Share of a segment's readings that must count."""
    within_band: float = 1.2
    """Times the edge of a low-pass up to which what passed it is looked at: it falls by half
    there, and the numbers are still those of noise;"""
    beyond_band: float = 4.0
    """and up to which the raw readings are: a drive filters what it records further up."""
    angles_summed: int = 2000
    """Angles of a spectrum, for the variance under it."""

    # A servo delta, read at the rate of its drives.
    servo_period_s: tuple[float, float] = (1e-4, 0.1)
    """Between samples: drives close their loops no faster, and slower rows show no acceleration."""
    least_turn_rad: float = 1e-3
    """Travel below which the joints rest: one count of a coarse encoder."""
    means_s: float = 0.01
    """Over which disturbances are averaged: an observer's estimate at full rate carries each step
    of the encoder."""
    smoothing_s: float = 0.04
    """Length of the polynomials that give speed and acceleration."""
    smoothing_degree: int = 3
    """Degree of these polynomials: the acceleration may change within one."""
    at_rest: float = 6.0
    """Standard deviations of the speed within which a joint may rest: friction may then be
    anything up to its size, and the sample says nothing."""
    slowest_share: float = 0.01
    """The same as a share of the highest speed, of any machine by its effort."""
    dithered: float = 0.3
    """Encoder counts per time constant of the observer below which each step makes the drive
    twitch: the arm goes to and fro in between, and friction does not brake its whole size."""
    around_rest_s: float = 0.02
    """Left out on either side of such samples: half the length of a polynomial sees them."""
    fewest_outside: int = 50
    """Readings of a sensor beside such a robot, below which the sensor is left alone."""
    least_usable: float = 0.05
    """Share of the samples in which a joint must move faster than that."""
    # Old values that a sensor repeats.
    chance: float = 1e-5
    """Below which repeated readings are stale. Readings correlate, so well below the alarm."""
    fewest_repeats: int = 10
    """Readings alike in a row, below which nobody counts: a fifth of a second at 50 Hz."""
    many: int = 3
    """From so many runs on the value they hold is asked for: one value again and again is the end
    of a range, not an old reading."""


OBSERVATIONS = ObservationOptions()
"""As every recording is read."""
