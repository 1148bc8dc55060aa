"""What is believed of a lone machine before its recording: odds of each effect, spreads of a file.

Spreads of what is not in the file stand with the machine, in `options`.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass


@dataclass(frozen=True, slots=True)
class LoneOddsOptions:
    """Natural logarithms of prior odds: judged, not counted, so that only their order is sure.

    -1 is one machine in four, -2 one in eight, -3 one in twenty, -4 one in 55, -6 one in 400.
    """

    everyday: float = -1.0
    """What wears or is set by hand: lag, play, friction and yielding of a drive, its home, the
    friction of an axis, offset and scale of a range sensor."""
    one_moment: float = -6.0
    """Lost steps, or a slip of an axis that counts none: at one moment of all there were."""

    # An axis that follows commands.
    ratio_of_stepper: float = -2.0
    """Teeth are counted, but microsteps and gears are typed into a file."""
    ratio_of_servo: float = -3.0
    """It closes its loop over what is read: only another encoder sees another ratio."""
    gear_error: float = -3.0
    """Periodic errors that a reading shows: gears are made so that it does not."""
    wave_below_a_step: float = -3.0
    """For one that is smaller than a step of the reading, in addition: it shows only through what
    lifts readings over their steps, and the hops of an axis that sticks lift them too."""
    ringing: float = -4.0
    """Frames ring for longer than a sample in light or tall machines only."""
    slow_drift: float = -4.0
    """A bend over the whole recording: warmth has a name on other machines, none on an axis."""

    # An axis driven by effort.
    stated_inertia: float = -2.0
    """The file's is computed from drawings, but that of a whole machine is mostly near."""
    effort_bias: float = -2.0
    """An amplifier's zero, or a weight that the file leaves out."""
    torque_constant: float = -3.0
    """Printed on the motor, and measured by its maker."""
    stribeck: float = -3.0
    """Every greased bearing has it, few recordings stay slow for long enough."""
    spring: float = -4.0
    """A cable or a spring at the axis: machines have one by design, and then it is in the file."""
    late_effort: float = -4.0
    """Effort and position are mostly read by one clock; what filters make of it is fitted anyway.
    """

    # A range sensor.
    crosstalk: float = -2.5
    """Needs a cover glass, or a cone that meets more than its target."""
    late_range: float = -1.5
    """Ranging takes tens of milliseconds, and few stamps allow for it."""
    warm_up_drift: float = -3.0
    """Seen in the first minutes, which few recordings hold."""

    # Other names of one operator, against the name it goes by.
    unknown_load_for_ratio: float = 0.0
    """A servo that yields under a weight, of which the file says nothing: yielding is the more
    frequent, but a file without a weight is mostly that of an axis without one."""
    unknown_load_for_home: float = -0.7
    """The same, against a zero set by hand, which every axis has."""
    drift_for_ratio: float = 0.0
    """Of an axis that turns at one speed: what it stands on, or its clock, drifts about as often as
    a ratio is typed wrong."""
    scale_for_ratio: float = -2.0
    """Of an axis that another device measures: those are calibrated, though figures for them are
    typed into files too."""
    late_sensor_for_lag: float = -1.0
    """A drive lags more often than a reading is late."""
    late_sensor_for_late_effort: float = -0.5
    """With no drive between effort and position either clock may be off."""
    viscous_for_lag: float = -1.5
    """Drag makes a drive late as its own loop does, and is mostly the smaller."""
    friction_of_stepper: float = -1.4
    """For play: tooth play is what a geared stepper has."""
    play_of_servo: float = -0.2
    """For friction: what stiction leaves a servo's loop is a little more frequent."""
    encoder_for_gear: float = -1.0
    """Encoders are made finer than gears."""
    gain_for_inertia: float = -0.7
    """Without a known force only their ratio shows; a torque constant is the better known."""
    friction_for_bias: float = -2.5
    """Friction that differs between both ways by as much: rare."""

    # The joints of a servo delta.
    unknown_of_joint: float = -6.0
    """Three joints have three times as many covariates as one axis, which has -5."""


@dataclass(frozen=True, slots=True)
class JointOddsOptions:
    """The same for the joints of a servo delta, by effect: bearings and grease change most, loads
    are changed by hand, masses and motors by exchange."""

    joint_friction: float = -1.0
    viscous_friction: float = -1.0
    """Bearings and grease: by wear and warmth."""
    payload: float = -1.5
    """Changed by hand, and not always in the file."""
    gravity_error: float = -2.0
    """Of arms with cables and screws."""
    inertia: float = -2.5
    """By exchange of a motor or an arm."""
    effort_offset: float = -3.0
    effort_gain: float = -3.0
    """Of drives that are calibrated where they are made."""


@dataclass(frozen=True, slots=True)
class FileSpreadOptions:
    """By how much a robot file is off, as a share, where nobody measured."""

    inertia_share: float = 0.3
    """Part weights and drawings."""
    gain_share: float = 0.1
    """A stated torque constant: drive makers give 10 %."""
    stepper_ratio_share: float = 0.02
    """Belts and rollers slip a little, wheels are turned to a hundredth."""
    servo_ratio_share: float = 0.01
    """A servo closes its loop over what is read: only another encoder sees another ratio."""
    range_scale_share: float = 0.02
    """A ranging sensor's clock is off by parts in a thousand, its optics by a percent or two."""


ODDS = LoneOddsOptions()
JOINT_ODDS: dict[str, float] = asdict(JointOddsOptions())
"""By effect."""
FILE_SPREADS = FileSpreadOptions()
"""As the engine is used."""
