"""The numbers by which tables of others are understood."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class GuessOptions:
    """For a table that says neither what its columns are nor their units; `inspect` shows each
    guess and the command that says otherwise."""

    # Which column is what.
    guessed_rows: int = 20_000
    """First rows that are looked at: what a column is shows in minutes."""
    least_filled: float = 0.5
    """Share of its rows that a column must hold to be anything."""
    seldom_empty: float = 0.1
    """Share of empty cells that is a log's habit, each sensor at its pace, and not reported."""
    fewest_in_common: int = 10
    """Rows that two columns must both hold to be compared."""
    alike: float = 0.8
    """Correlation from which two columns are one motion, asked for and seen."""
    one_motion: float = 0.99
    """Concordance from which two columns are readings of one motion: two joints that move in step
    are rarely so near."""
    as_far: float = 2.0
    """Times by which two columns without names that are one motion differ in travel at most: a
    reading that lags or overshoots more is rarer than a second joint."""
    alike_slope: float = 0.95
    """Correlation with the slope of another from which a column is its velocity."""
    least_share: float = 0.1
    """Share of a column's variance that its partner must explain before it counts for it: with a
    few dozen rows and four shapes chance explains less."""
    slope_rows: tuple[int, ...] = (1, 3, 10, 30, 100)
    """Over so many rows the motion is compared: over few the noise of the position rules, over many
    the drift of the velocity."""
    longest_lead: int = 40
    """Rows by which what was asked for may be ahead of what was seen: 0.8 s at 50 Hz."""
    large_count: float = 200.0
    """Travel beyond which whole numbers are step counts rather than labels or states."""
    mostly_still: float = 0.1
    """Share of its rows in which a column that rests in turns changes at most."""
    few_places: float = 0.3
    """Share of its rows up to which a column has few values: those of somebody with a ruler."""
    most_runs: float = 0.02
    """Times that a clock may start again, as a share of the rows: runs shorter than fifty rows are
    none."""

    roughest: float = 1.0
    """Second differences of a motion over its spread; noise has 2.4."""
    led_rows: int = 4000
    """First rows in which it is looked who is ahead."""
    surest_fit: float = 3.0
    """Powers of ten of the unexplained share of a reading, beyond which a better fit tells nothing:
    two sensors of one axis are alike to the last digits."""
    came_first: float = 0.75
    """What it is worth in a pair that the command comes first,"""
    own_name: float = 0.5
    """that both names begin alike,"""
    plainly_named: float = 0.75
    """and that a name is a position's without a word of its being measured; a clear name is 1."""
    more_than_alone: float = 0.03
    """Share of its variance by which acceleration and speed together must explain more of an effort
    than either alone."""
    same_difference: float = 0.1
    """Share of its own spread within which a column is the difference of two others, all
    rounded."""
    fast_of_top: float = 0.5
    """Share of the top speed from which an axis moves fast: a drive gives a torque then."""
    no_torque: float = 0.02
    """Share of the largest torque up to which there is none."""
    pulled_at: float = 0.1
    """Share of the rows in which something must pull to be a load."""
    asked_alike: float = 0.9
    """Correlation with the position from which what is called an effort may be its command,"""
    asked_as_far: float = 1.5
    """where the travel of neither is more than so many times that of the other."""
    compared_first: int = 200
    """Rows, spread over all, by which most pairs of columns are found to differ."""
    few_columns: int = 8
    """Columns up to which it is looked for: all triples are compared."""

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
    near_counts: float = 0.01
    """Share by which the counts of a turn by a speed may differ from the round number that they
    are: 2000 and 2048 differ by 2.4 %."""
    one_turn_rad: float = 6.2832
    """Travel of an axis without a unit: more is degrees or mm more often than rad or m."""
    pulses_us: tuple[float, float] = (400.0, 2600.0)
    """Pulses that hobby servos take are 500 to 2500 us long, and a little more."""
    pulse_deg: float = 0.09
    """Degrees that one microsecond of such a pulse turns most of them: 180 over 2000 us."""
    highest_v: float = 5.5
    """What a converter reads at most, and a little more."""
    encoder_bits: tuple[int, int] = (8, 24)
    """Steps of a turn as powers of two: from the coarsest magnetic encoders to the finest glass."""
    near_unit_step: tuple[float, float] = (0.001, 0.01)
    """Share of such a step by which the step of a reading may differ, at least (a turn is parted
    into 4095 too) and at most: decimal steps (0.1 mm, 0.001 rad) are 4 % and more from all of
    them."""
    slip: float = 0.5
    """Share of a step by which a grid may slip over all that was read: 2 pi/16384 behind a gear of
    9 is within 0.8 % of 360/2^23 degrees, and slips a step in 140."""
    places_for_a_step: int = 8
    """At which readings must have stood before they have a step."""
    same_reading: float = 1e-9
    """Share of the whole travel within which two readings are the same but for their last digit."""
    off_place: float = 0.15
    """Share of the step by which readings with few decimals may differ from their places."""
    few_turns_deg: float = 1440.0
    """Travel of an axis without a unit: more is seconds of arc or counts rather than degrees or
    mm."""
    far_from_read: float = 50.0
    """Times that a known distance and its reading differ from where on their units do."""
    longest_m: float = 15.0
    """More is millimetres: no distance sensor of this kind sees so far, and no axis is so long."""

    # What the times and zeros are like.
    clockwork: float = 1e-6
    """Share of the step of a first column by which its steps differ where it is a time
    though its name says something else."""
    rate_hz: float = 100.0
    """Rows a second that are written for a table without times, to be put right by hand."""
    large_jitter: float = 0.2
    """Share of the usual step of time: a step that differs by more is uneven,"""
    most_uneven: float = 0.1
    """and so are the times where more than this share of the steps is: then the stamps are those of
    whoever logged. A missing row or a pause now and then is none."""
    row_missing: float = 1.7
    """Usual steps of time from which one is longer than usual: a lost row makes two of one."""
    zeros_apart: float = 0.25
    """Part of the whole motion by which command and reading lie apart where their zeros differ."""


GUESSES = GuessOptions()
"""As every table is looked at."""
