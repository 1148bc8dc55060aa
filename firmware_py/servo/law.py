"""Acceleration control with disturbance observer (Uzunovic 2013, section 4), a joint at a time.

All on the rotor's side of the gear, discrete at the loop's period T. With a = 1 - exp(-g T) a
first-order low-pass of bandwidth g is y += a (u - y), and g s / (s + g) is (a / T) times the
difference u - y taken before: unit slope in, exactly 1 out. docs/decisions/
acceleration-control.md has the transfer functions.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from math import exp

from deltactl.drivers.current_drives import JOINTS, Counts, Three
from deltactl.models.servo_drive import ServoDrive


@dataclass(frozen=True, slots=True)
class LawSettings:
    """What the law must know; `of` takes it from a robot file, `replace` makes experiments."""

    period_s: float
    gear_ratio: float
    rad_per_count: float
    """Arm angle of an encoder count [rad]."""
    torque_constant_nmpa: float
    nominal_inertia_kgm2: float
    current_limit_a: float
    reference_bandwidth_radps: float
    velocity_bandwidth_radps: float
    disturbance_bandwidth_radps: float
    velocity_gain_1ps: float = 100.0
    position_gain_1ps2: float = 1000.0
    disturbance_observer: bool = True
    """False takes the estimate out of the current; it is still made."""

    @classmethod
    def of(cls, drive: ServoDrive) -> LawSettings:
        """The settings of a robot file's drive section."""
        taken = (field.name for field in fields(cls) if field.name != "disturbance_observer")
        return cls(**{name: getattr(drive, name) for name in taken})

    @property
    def amperes_per_radps2(self) -> float:
        """m_jjn / K_Tjn: current for a unit of rotor acceleration."""
        return self.nominal_inertia_kgm2 / self.torque_constant_nmpa

    def share(self, bandwidth_radps: float) -> float:
        """How much of the way a low-pass of this bandwidth goes in one period."""
        return 1.0 - exp(-bandwidth_radps * self.period_s)


class JointLaw:
    """Equations 5 and 6 and both observers of one joint: encoder count in, current out."""

    __slots__ = (
        "_amperes",
        "_disturbance_share",
        "_gear",
        "_limit_a",
        "_momentum",
        "_observed",
        "_position_gain",
        "_reference_rate",
        "_reference_share",
        "_rotor_per_count",
        "_slow_angle",
        "_slow_current",
        "_slow_reference",
        "_slow_speed",
        "_velocity_gain",
        "_velocity_rate",
        "_velocity_share",
        "current_a",
        "disturbance_a",
    )

    def __init__(self, settings: LawSettings):
        period_s = settings.period_s
        self._gear = settings.gear_ratio
        self._rotor_per_count = settings.gear_ratio * settings.rad_per_count
        self._amperes = settings.amperes_per_radps2
        self._velocity_gain = settings.velocity_gain_1ps
        self._position_gain = settings.position_gain_1ps2
        self._limit_a = settings.current_limit_a
        self._observed = 1.0 if settings.disturbance_observer else 0.0
        self._reference_share = settings.share(settings.reference_bandwidth_radps)
        self._reference_rate = self._reference_share / period_s
        self._velocity_share = settings.share(settings.velocity_bandwidth_radps)
        self._velocity_rate = self._velocity_share / period_s
        share = self._disturbance_share = settings.share(settings.disturbance_bandwidth_radps)
        # g J / K, made so that a constant acceleration is seen as exactly what it takes.
        self._momentum = settings.amperes_per_radps2 * share / ((1.0 - share) * period_s)
        self.reset(0.0, 0)

    def reset(self, reference_rad: float, count: int) -> None:
        """Begin at rest, at this arm reference and encoder count."""
        self._slow_reference = reference_rad * self._gear
        self._slow_speed = 0.0
        self._slow_angle = count * self._rotor_per_count
        self._slow_current = 0.0
        self.current_a = 0.0
        """Newest command, within the limit."""
        self.disturbance_a = 0.0
        """Newest estimate of the disturbance as a current: what acceleration does not explain."""

    def tick(self, reference_rad: float, count: int) -> float:
        """One period: arm reference [rad] and encoder count in, motor current [A] out."""
        reference = reference_rad * self._gear
        ahead = reference - self._slow_reference
        self._slow_reference += self._reference_share * ahead
        speed = self._reference_rate * ahead
        ahead = speed - self._slow_speed
        self._slow_speed += self._reference_share * ahead

        angle = count * self._rotor_per_count
        turned = angle - self._slow_angle
        self._slow_angle += self._velocity_share * turned
        velocity = self._velocity_rate * turned

        momentum = self._momentum * velocity
        slow = self._slow_current
        slow += self._disturbance_share * (self.current_a + momentum - slow)
        self._slow_current = slow
        disturbance = slow - momentum

        current = (
            self._amperes
            * (
                self._reference_rate * ahead
                - self._velocity_gain * (velocity - speed)
                - self._position_gain * (angle - reference)
            )
            + self._observed * disturbance
        )
        limit = self._limit_a
        if current > limit:
            current = limit
        elif current < -limit:
            current = -limit
        self.disturbance_a = disturbance
        self.current_a = current
        return current


class AccelerationControl:
    """The law of all three joints. Each is controlled on its own: eq. 4 calls the rest disturbance.

    One `LawSettings` for all joints, or one each.
    """

    def __init__(self, settings: LawSettings | tuple[LawSettings, LawSettings, LawSettings]):
        each = settings if isinstance(settings, tuple) else (settings,) * JOINTS
        self.joints = (JointLaw(each[0]), JointLaw(each[1]), JointLaw(each[2]))
        self._first, self._second, self._third = (joint.tick for joint in self.joints)

    def reset(self, references_rad: Three, counts: Counts) -> None:
        """Begin at rest, at these arm references and encoder counts."""
        for joint, reference_rad, count in zip(self.joints, references_rad, counts, strict=True):
            joint.reset(reference_rad, count)

    def tick(self, references_rad: Three, counts: Counts) -> Three:
        """One period: arm references [rad] and encoder counts in, motor currents [A] out."""
        return (
            self._first(references_rad[0], counts[0]),
            self._second(references_rad[1], counts[1]),
            self._third(references_rad[2], counts[2]),
        )
