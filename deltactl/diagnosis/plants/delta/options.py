"""The numbers of a delta: what bounds its fits, and its next runs.

Where the fit of an effect starts, how far it goes and what careful building leaves of it are on its
card.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class DeltaFitOptions:
    """From where the fit of an effect starts: as far apart as it still finds its way."""

    warm_up_shares: tuple[float, ...] = (0.06, 0.2, 0.6, 2.0)
    """Time constants of warming, as shares of the recording."""
    soonest_warm_s: float = 8.0
    """No arm and no sensor is warm sooner: less would be a wrong length from the start."""
    soonest_warm_share: float = 0.25
    """Share of a recording up to which a short one still may show warming."""
    most_warm_ups: float = 40.0
    """Time constants in a long recording: what is warm sooner is seen in too few of its readings,
    """
    slowest_warm_times: float = 4.0
    """and what takes so many times as long drifts straight on."""
    shortest_period_rad: float = 1e-2
    """Shortest period of a periodic error where the arms hardly move."""

    # Fits near a point.
    starts_beside: int = 2
    """Starts from which an effect is fitted by itself, and"""
    steps_beside: int = 4
    """Gauss-Newton steps of each; a set is fitted to its end later."""
    worth: float = 9.0
    """Chi-square that a start must gain before it is fitted: three standard deviations."""
    least_size: float = 0.03
    """Share of its usual size with which an effect is looked at that fits best without any."""
    little_beside: float = 1.0
    """Chi-square of a step that ends such a fit,"""
    little: float = 0.05
    """and the fit of a set."""
    most_steps: int = 12
    """Steps at which the fit of a set is given up."""

    far: float = 10.0
    """Model error, in variances of noise, from which on what is not linear in large effects shows
    beside the noise,"""
    far_share: float = 0.3
    """and the share of it at which the choice near a point ends: the rest is left to the next."""
    at_once: int = 4
    """Effects that are added near one point; further ones near the next."""

    # Jumps.
    edge: float = 0.02
    """Share of the recording at either end, in which a jump is an offset or nothing."""
    least_own: float = 0.02
    """Share of a jump that what is fitted already must leave for its time to be tried."""
    # Poses that a machine a little off its file may not reach.
    most_fragile: float = 0.2
    """More than this share is not left out: then the file is wrong, or the motion is all there."""


@dataclass(frozen=True, slots=True)
class NextRunOptions:
    """For the motions that are proposed: safe first, then telling. Shares are of the angles
    used."""

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
    """Sizes of a motion; the largest safe one is taken: a smaller one tells less."""
    corners: int = 40
    """Corners of the polygon that represents a circle: it keeps within 0.3 % of the radius."""
    heights: tuple[float, ...] = (0.3, 0.6)
    """At which circles are drawn: high and low."""
    circle_share: float = 0.2
    """Radius of a circle over the forearm."""
    approached: tuple[float, ...] = (0.15, 0.5, 0.85)
    from_beside: tuple[float, ...] = (-0.12, 0.0, 0.12, 0.0)
    """Angles to which a motor comes from below and from above, and how far it goes there."""
    sweep: tuple[float, ...] = (0.6, 0.2, 0.8, 0.1, 1.0, 0.0)
    """Where a motor turns back: reversals of growing size."""
    survey_poses: int = 16
    """Random poses: more than a delta's lengths and homes together."""
    survey_tries: int = 20
    """For each of them, as some are not safe."""
    survey_seed: int = 7
    """The same poses each time, so that the same recording has the same proposal."""

    # How fast.
    fast_radps: float = 0.5
    """Joint speed that a stepper with a gear starts and stops at without a ramp."""
    pulses_s: float = 2e-4
    """Shortest step period proposed: well under the start-stop rate of a geared stepper."""
    software_pulses_s: float = 2e-3
    """The same where a program makes the pulses (`steps.backend: gpiozero`)."""
    shortest_period_s: float = 0.01
    """Recordings sampled faster are thought of as sampled this fast, noise averaged."""
    readings_after_s: float = 0.5
    """After the last step, in which the platform comes to rest."""


@dataclass(frozen=True, slots=True)
class ProcessOptions:
    """Gaussian processes that represent what has no name."""

    knots: int = 48
    """Between which a process is a straight line: a few to the shortest length."""
    lengths: tuple[float, ...] = (1.0, 0.4, 0.15, 0.06)
    """Lengths of the kernel, as shares of the covariate's range: from one bend to a dozen."""
    ratios: tuple[float, ...] = (2.0, 6.0, 20.0, 60.0, 200.0, 600.0)
    """Sizes that are tried, in standard deviations to which the best seen shape is known."""
    least_share: float = 1e-5
    """Share of the kernel's largest direction below which others count for nothing."""
    least_chi2: float = 0.1
    """Chi-square of a usual size below which a direction of it is left out: nothing shows it."""
    least_move: float = 0.02
    """Share of a covariate's range by which it moves before the way it came is another."""
    opened: float = 5.0
    """Log evidence that one must gain to be looked at among the others,"""
    most: int = 8
    """and how many are."""
    past_s: tuple[float, ...] = (0.06, 0.3, 1.5)
    """How long before a reading the past is looked at: three readings at 50 Hz, and five and 25
    times that."""
    least_past: float = 0.05
    """What the past must explain of what the present does; less is a shape that is not quite right.
    """
    fewest_turns: float = 6.0
    """Turns of a wave in a recording; slower ones are processes over time."""
    fastest: float = 0.2
    """Turns of a wave a sample, at most."""
    finer: int = 4
    """Frequencies looked at, for each that the length of the recording resolves."""
    between: int = 9
    """Frequencies tried around the strongest."""
    most_transformed: int = 2**18
    """Samples in which the frequency is looked for: an hour and a half at 50 Hz."""
    tied: float = 5.5
    """Log evidence within which two covariates count as tied: one in a thousand by chance."""


PROCESSES = ProcessOptions()
DELTA_FITS = DeltaFitOptions()
NEXT_RUNS = NextRunOptions()
"""As the engine is used."""
