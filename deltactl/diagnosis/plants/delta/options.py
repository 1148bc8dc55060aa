"""The numbers of a delta: how its fits start, what its building leaves, and its next runs.

How far a size may go, and the step of its derivative, stand with the effect's row in `candidates`.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass


@dataclass(frozen=True, slots=True)
class DeltaFitOptions:
    """From where the fit of an effect starts: as far apart as it still finds its way."""

    plays_rad: tuple[float, ...] = (0.0025, 0.006, 0.015)
    """Widths of play and of friction: from what a good gear has to what one sees by eye, apart by
    a factor of two and a half."""
    drags: tuple[float, ...] = (5.0, 10.0, 25.0)
    """N m s/rad, against which the load pulls the arm through its play."""
    sticks: float = 1e4
    """Drag at which the arm stays in the play wherever it was left."""
    lags_s: tuple[float, ...] = (0.02, 0.1)
    """One and five samples at 50 Hz, for lag and dead time each."""
    gear_periods: tuple[int, ...] = (1, 2, 3, 4, 5, 6, 8, 10, 12, 15, 16, 20, 25, 30, 40, 50)
    """Errors per turn of the arm that a gear or coupling may have."""
    ringing_hz: tuple[float, ...] = (0.7, 1.2, 2.0, 3.2, 5.0, 8.0, 12.0, 18.0)
    """Each 1.6 times the one before: from a cable that swings to what 50 readings a second still
    show."""
    ringing_damping: tuple[float, ...] = (0.05, 0.2)
    """A bolted frame, and one that is held by hand or rubber."""
    warm_up_shares: tuple[float, ...] = (0.06, 0.2, 0.6, 2.0)
    """Time constants of warming, as shares of the recording."""
    soonest_warm_s: float = 8.0
    """No arm and no sensor is warm sooner: less would be a wrong length from the start."""
    soonest_warm_share: float = 0.25
    """Of a recording, up to which a short one still may show warming."""
    most_warm_ups: float = 40.0
    """Time constants in a long recording: what is warm sooner is seen in too few of its readings,
    """
    slowest_warm_times: float = 4.0
    """and what takes so many times as long drifts straight on."""
    shortest_period_rad: float = 1e-2
    """Of a periodic error where the arms hardly move."""
    contact_shares: tuple[float, ...] = (0.02, 0.05, 0.1, 0.2, 0.35)
    """Heights of a stop, as shares of the heights that the platform was sent to."""
    grips: tuple[float, ...] = (0.0, 1.5)
    """A smooth stop, and rubber on steel."""

    # Poses that a machine a little off its file may not reach.
    length_off: float = 0.02
    """Share of the forearm,"""
    home_off_rad: float = 0.02
    """and angle, by which a faulty machine may well be off; moderate faults are half as large."""
    most_fragile: float = 0.2
    """More than this share is not left out: then the file is wrong, or the motion is all there."""


@dataclass(frozen=True, slots=True)
class BuildOptions:
    """How far a machine built with care may be off everywhere, as standard deviations.

    The fields are called after the effects; each says its unit.
    """

    home_offset: float = 2e-3
    """rad, 0.1 deg: a stop or a switch that the arm is homed to."""
    upper_arm_length: float = 5e-4
    """m, between the centres of joints that are glued, printed or drilled on a bench."""
    forearm_length: float = 5e-4
    """m, the same."""
    base_radius: float = 1e-3
    """m, the difference of two radii."""
    motor_azimuth: float = 3e-3
    """rad: 1 mm on a base of 325 mm."""
    frame_tilt: float = 2e-3
    """rad: 1 mm over half a metre, between sensors and base."""
    sensor_offset: float = 1.5e-3
    """m, of a board that is held by two screws, and of what a ranging sensor leaves."""
    sensor_scale: float = 2e-3
    """1: 1 mm in half a metre."""
    gear_ratio: float = 1e-3
    """1: teeth are counted, belts stretch."""


@dataclass(frozen=True, slots=True)
class RunoutOptions:
    """Of the gears, beside what building leaves."""

    once_a_motor_turn_rad: float = 1e-3
    """Usual size of the periodic error of a gear whose input shaft runs a little out of true."""


@dataclass(frozen=True, slots=True)
class NextRunOptions:
    """Of the motions that are proposed: safe first, then telling. Shares are of the angles used."""

    # Where motions go.
    lowest_deg: float = 0.0
    highest_deg: float = 80.0
    """Angles used where the limits allow them: arms from level to steeply down."""
    off_limits: float = 0.05
    """Share of the limits' own span that is left free at either end."""
    pose_step_deg: float = 2.0
    """Poses along a move are looked at this close together."""
    margin_factor: float = 2.0
    """How much further from singular a proposal keeps than the robot file asks for: the machine is
    not quite the file's, or nothing would be asked."""
    sizes: tuple[float, ...] = (1.0, 0.8, 0.6, 0.4, 0.25)
    """Of a motion, of which the largest safe one is taken: a smaller one tells less."""
    corners: int = 40
    """Corners of the polygon that stands for a circle: it keeps within 0.3 % of the radius."""
    heights: tuple[float, ...] = (0.3, 0.6)
    """At which circles are drawn: high and low."""
    circle_share: float = 0.2
    """Radius of a circle over the forearm."""
    survey_poses: int = 16
    """Random poses: more than a delta's lengths and homes together."""
    survey_tries: int = 20
    """For each of them, as some are not safe."""
    survey_seed: int = 7
    """The same poses each time, so that the same recording has the same proposal."""

    # How fast.
    fast_radps: float = 0.5
    """Joint speed that a stepper with a gear starts and stops at without a ramp."""
    top_speed: float = 0.98
    """Quantile of the recording's joint speeds that counts as the highest, single glitches aside.
    """
    pulses_s: float = 2e-4
    """Shortest step period proposed: well under the start-stop rate of a geared stepper."""
    software_pulses_s: float = 2e-3
    """The same where a program makes the pulses (`steps.backend: gpiozero`)."""
    shortest_period_s: float = 0.01
    """Recordings sampled faster are thought of as sampled this fast, noise averaged."""
    readings_after_s: float = 0.5
    """After the last step, in which the platform comes to rest."""


DELTA_FITS = DeltaFitOptions()
BUILD = BuildOptions()
RUNOUT = RunoutOptions()
NEXT_RUNS = NextRunOptions()
"""As the engine is used."""
TOLERANCES: dict[str, float] = asdict(BUILD)
"""By effect."""
