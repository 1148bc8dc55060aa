"""The numbers of a machine by itself: an axis, a range sensor, the joints of a servo delta.

Spreads are standard deviations of a prior; odds are on the effects' cards. The step of a size's
numerical derivative is with its regressor.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class LoneOptions:
    """What all of them share."""

    limit_starts: tuple[float, ...] = (0.9, 0.75, 0.5, 0.1)
    """Limits to start from, as shares of the way from the usual to the largest effort or speed."""
    near_bound: float = 0.01
    """Share of a bound within which a size sits at it, and was not found."""
    size_of_mismatch: float = 2.0
    """Usual size of play, droop, offset and crosstalk, in times the model error: half of a play
    lies on either side, and of two that cancel each is larger than what they leave."""
    unknown_of_mismatch: float = 0.5
    """Usual size of an unknown: half of what is to be explained."""
    longest_lag_s: float = 2.0
    """Longest lag, and longest dead time, that a drive is looked for: beyond, it has arrived."""
    lag_spread_s: float = 0.1
    """A drive's lag is tens of milliseconds; a hobby servo's a tenth of a second (SO-101,
    STS3250)."""
    fewest_pieces: int = 2
    """Pieces of a spline term over few readings or places: one bend."""
    rows_a_piece: int = 15
    """Readings in a piece, at least."""


@dataclass(frozen=True, slots=True)
class CommandedAxisOptions:
    """An axis that follows commands: which rows count, what may differ, where its fits start."""

    # Rows.
    fewest_followed_rows: int = 40
    """Below which lag, play and a ratio share too few readings to be distinguished."""
    most_followed_rows: int = 2000
    """Rows beyond which an axis tells no more: readings are correlated over many samples."""
    most_followed_samples: int = 10000
    """A longer recording is worked on in stretches that have so many samples together."""
    rows_a_lag: float = 2.0
    """Samples within a drive's usual lag that are enough to show how late it is."""
    settling_lags: float = 3.0
    """Usual lags after a move until a drive has arrived: 5 % of a first-order lag are left."""
    of_each_kind: tuple[float, float] = (0.1, 0.9)
    """Shares of rows in motion between which both kinds have enough to show a noise of their own.
    """
    settles_within: float = 0.05
    """Share of the travel: nearer to where it is a moment later an axis may just settle, as in any
    rest. And share of a longer way after which it has arrived."""
    fewest_rests: int = 12
    """At a place, under a load, to show a noise of their own: within one an axis is off by the same
    amount, and as many sizes as there are rests fit them all."""
    another_load: float = 0.1
    """Share of the load's range by which it has to change to make another rest."""
    steady_correlation: float = 0.999
    """Correlation of command and time above which an axis turns steadily and they are one."""
    least_move_share: float = 1e-6
    """Share of the travel: a command that changes by less rests."""
    full_steps_per_turn: float = 200.0
    """Full steps of the usual stepper motor (1.8 degrees each): the least that it loses is one."""

    # What may differ, and by how much.
    gap_of_a_lag: float = 0.02
    """Share of the gap between both directions that a delay makes, below which nothing else is
    learned from it: no drive is quite one dead time and one time constant."""
    together_of_longest: float = 0.95
    """Lag and dead time that are longer together sit at that bound."""
    free_constant_spread: float = 1e3
    """Times the model error, of the constant of an arbitrary zero: as good as any."""
    widest_play_share: float = 0.6
    """Share of the travel: with more play an axis would hardly move."""
    play_of_travel: float = 0.02
    """Usual play is at least this share of the travel, so that a small model error does not forbid
    it."""
    build_up: float = 0.1
    """Usual way over which a servo's friction builds up, in widths of the gap between directions:
    contacts are stiffer than the position loop that winds up against them."""
    grip_of_yielding: float = 2.0
    """Friction winds a spring up both ways by no more than the load that makes it."""
    second_harmonic: float = 0.5
    """Usual size of a gear's second harmonic, in that of the first: eccentricity comes first."""
    most_begins: int = 4
    """Stretches whose side of the play at the start is fitted; later ones begin in its middle."""
    coarsest_steps: float = 4.0
    """Steps of the reading in the shortest wave: rounding itself repeats with every step."""
    most_waves: float = 60.0
    """Over the travel, of a wheel or a screw that turns so often: the first of two ranges. Beyond
    it are teeth and strain waves, as far as the places of the readings resolve them."""
    more_than_waves: float = 1.2
    """Times that number of waves that a recording resolves at least for finer ones to be sought."""
    cells_of_waves: int = 8192
    """Cells of the travel in which places are distinguished: eight in the shortest wave."""
    places_a_wave: float = 4.0
    """As many as a wave with its second harmonic has sizes."""
    places_alike: float = 0.7
    """Share of the places at which a wave has one phase: there it looks like a constant."""
    fewest_waves: float = 1.3
    """Fewer over the travel look like a ratio or a bend,"""
    some_waves: float = 2.0
    """and fewer than these take what is smooth in a recording."""
    ringing_of_rate: float = 0.4
    """Highest frequency as a share of the sampling rate: five samples in two periods,"""
    fastest_ringing_hz: float = 25.0
    """and what no axis exceeds by enough to be read."""
    slowest_ringing_hz: float = 0.1
    """a load on 25 m of rope swings no slower,"""
    ringing_periods: float = 5.0
    """and a recording shows so many periods."""
    damping: tuple[float, float] = (0.01, 0.9)
    """Rings for a hundred periods, or hardly at all."""
    fewest_moments: float = 4.0
    """At which a jump may have come, one a second: in a short recording, too, it was one of some.
    """
    alarming_chi2: float = 16.0
    """Gain of a jump that is about to raise the alarm. The highest of all moments exceeds a high
    gain as often as gain x log(readings) independent tests (James, James and Siegmund 1987,
    Biometrika 74, 71-83, to leading order)."""

    # Spline terms.
    axis_pieces: int = 6
    """Over position, speed or load; twice as many over time, in which anything comes and goes."""

    # Where fits start.
    play_starts: tuple[float, ...] = (0.05, 0.15, 0.4, 1.0)
    """Widths of play, as shares of how far reading and prediction are apart,"""
    widest_start: float = 0.5
    """and at most this share of the travel."""
    side_starts: tuple[float, ...] = (-0.7, 0.0, 0.7)
    """Where in its play an axis begins: towards either side, and its middle."""
    known_starts: int = 21
    """Places in a play of the robot file that are tried: a twentieth of it is below any finding."""
    wave_starts: int = 3
    """Highest peaks of the residual's spectrum over the travel that are fitted,"""
    waves_apart: float = 0.6
    """and how far they are apart: nearer is the same peak. In waves over the travel."""
    steps_a_wave: int = 6
    """Steps of the scan for each wave: a peak is one wave wide."""
    ringing_apart: float = 1.8
    """Ratio of two frequencies to start from,"""
    ringing_from: float = 1.5
    """the first so many times the slowest,"""
    ringing_up_to: float = 0.9
    """the last this share of the highest,"""
    damping_start: float = 0.1
    """with the damping of a bolted frame."""
    jump_edge_rows: int = 4
    """Rows at either end at which no jump starts: each side must show its mean,"""
    jump_edge_share: int = 200
    """and one row in so many of a long recording."""

    # How long it takes.
    most_kept: int = 128
    """Predictions that are kept for fits that pass there again: it changes no answer."""


@dataclass(frozen=True, slots=True)
class ForcedAxisOptions:
    """An axis by its effort. Periods are of the low-pass that both sides of the balance pass."""

    # Rows.
    wider: tuple[float, ...] = (1.0, 2.0, 4.0, 8.0)
    """Times the usual low-pass, the first that leaves as many samples."""
    fewest_forced_rows: int = 60
    """Rows of a recording; half as many must be in clear motion: inertia and friction need a few
    reversals between them."""
    resolved: float = 2.0
    """Times the noise of the velocity below which an axis may rest: friction is then anything."""
    smeared_periods: float = 0.3
    """By which what happens at a rest is smeared into the motion."""
    rest_periods: float = 0.15
    """For which an axis that is slow rests rather than turns round."""
    periods_a_row: float = 0.25
    """Between rows that count: nearer ones repeat each other."""
    steeper: tuple[float, ...] = (0.5, 0.8, 0.95)
    """Shares of the rows whose effort changes less: the others have noises of their own."""
    narrower: float = 0.6
    """Times the low-pass's edge, of the second preparation: narrow enough to move a size that
    hangs on the filter, wide enough to keep the motion."""
    turning_share: float = 1e-3
    """Share of the top speed within which friction changes sides even without noise."""

    # What may differ.
    clocks_s: float = 0.001
    """By how much effort and position may be apart in time: filters of the current, sampling,"""
    clocks_periods: float = 0.25
    """and at least so much of a sampling period, for which effort is held."""
    as_stated: float = 0.01
    """Share by which inertia and gain are off on any machine: parts are not weighed more exactly,
    nor is a motor's torque constant measured."""
    weighed_rad: float = 1.0
    """Travel over which a weight's pull is no straight line."""
    unknown_of_size: float = 0.3
    """Usual size of an unknown: a third of all forces."""
    stribeck_of_size: float = 0.5
    """Usual Stribeck friction, and usual pull of a spring, as a share of all forces."""
    force_pieces: int = 10
    """Pieces of a spline term: forces by position have more bends than positions by command."""


@dataclass(frozen=True, slots=True)
class RangeSensorOptions:
    """A range sensor by itself."""

    most_ranged_rows: int = 6000
    """Longer recordings are averaged to so many: neighbours are readings of one distance."""
    fewest_ranged_rows: int = 20
    """A calibration table is short, and each of its rows may be the mean of many readings."""
    gross_from_median: float = 30.0
    """Times the usual distance from the median beyond which a reading says nothing of a sensor."""
    most_gross_ranges: float = 0.2
    """Share of the readings: where more are so far off, that is how the sensor reads."""
    moving_target: float = 0.3
    """Share of rows with a new distance above which the target moves rather than rests at places.
    """
    least_travel_m: float = 1e-6
    """Distances nearer together are one."""
    late_range_spread_s: float = 0.1
    """A distance sensor measures for tens of milliseconds, and a bus may hold it for as long."""
    warm_up_periods: float = 2.0
    """Sampling periods of the soonest warming,"""
    warm_up_spans: float = 3.0
    """and lengths of the recording of the slowest."""
    range_pieces: int = 8
    """Pieces of a spline term: ranging errors wave over the distance."""
    places_a_piece: int = 4
    """Places in a piece, at least: over distance and time together half as many shapes
    as places, so that how places differ by themselves still shows."""


@dataclass(frozen=True, slots=True)
class ServoJointOptions:
    """The joints of a servo delta, by what disturbance observers say."""

    most_joint_rows: int = 4000
    """Rows of three joints beyond which more tell nothing."""
    joints_of_samples: int = 3
    """Times the fewest samples of a recording: each joint needs its own."""
    observer_late_spread_s: float = 0.001
    """Spread of the observer's lag beyond the file's, and of the clocks: a period or two of a
    drive."""
    joint_pieces: int = 8
    """Pieces of a spline term over one joint's travel or speed, or time."""
    inertia_of_rotor: float = 3.0
    """Times the file's spread of the rotor: arms and loads reflected on it make it larger."""


@dataclass(frozen=True, slots=True)
class FileSpreadOptions:
    """By how much a robot file is off, as a share, where nobody measured."""

    inertia_share: float = 0.3
    """Part weights and drawings."""
    gain_share: float = 0.3
    """Drive makers give 10 % for a torque constant, and state it by rms or by peak amperes, which
    differ by a factor of 1.41."""
    stepper_ratio_share: float = 0.02
    """Belts and rollers slip a little, wheels are turned to a hundredth."""
    servo_ratio_share: float = 0.01
    """A servo closes its loop over what is read: only another encoder sees another ratio."""
    range_scale_share: float = 0.02
    """A distance sensor's clock is off by parts in a thousand, its optics by a percent or two."""


LONE = LoneOptions()
COMMANDED_AXIS = CommandedAxisOptions()
FORCED_AXIS = ForcedAxisOptions()
RANGE_SENSOR = RangeSensorOptions()
SERVO_JOINTS = ServoJointOptions()
FILE_SPREADS = FileSpreadOptions()
"""As the engine is used."""
