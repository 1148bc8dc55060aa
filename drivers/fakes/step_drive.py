"""A closed-loop stepper drive (like the CL57T) with its motor: edges in, position and alarm out."""

from __future__ import annotations

from typing import NamedTuple


class DriveLimits(NamedTuple):
    """What the drive and its motor bear.

    The electrical times are those of the CL57T manual's sequence of control signals. The
    mechanical ones are round figures for a lightly loaded NEMA 23 at 1600 microsteps a turn,
    not taken from a data sheet; they let it start from rest at up to 25 kHz.
    """

    enable_ns: int = 200_000_000
    direction_setup_ns: int = 2_000
    pulse_ns: int = 1_000
    low_ns: int = 1_000
    speed_hz: float = 60_000.0
    acceleration_hz_per_s: float = 4e6
    lag_steps: float = 80.0
    """Further behind the command (18 degrees of the motor), an edge moves nothing."""
    following_error_steps: int = 160
    """So many edges lost by lag, and the drive trips."""


class SimulatedDrive:
    """Counts rising edges of STEP, signed by DIR, as the motor follows them.

    An edge is lost (`lost`) when the drive is not enabled or has tripped, when pulse, pause
    or DIR set-up are too short, or when the rotor cannot follow. Taking ENA away clears a trip.
    Does not model: torque of the load, resonance, current reduction, a rotor that coasts on
    after an abrupt stop, or arms that drop when the drive lets go.
    """

    def __init__(self, limits: DriveLimits | None = None, inverted: bool = False):
        self.limits = limits or DriveLimits()
        self.position_steps = 0
        self.edges = 0
        self.lost = 0
        self.alarm = False
        self.stalled = False
        """Something holds the rotor: no edge moves it."""
        self._mounting = -1 if inverted else 1
        self._sign = -self._mounting
        self._enabled = False
        self._enabled_ns = self._turned_ns = self._rose_ns = self._fell_ns = -(10**18)
        self._counted = 0
        self._lag_lost = 0
        self._rotor_steps = 0.0
        self._rotor_hz = 0.0
        self._rotor_ns = -(10**18)

    def set_enabled(self, on: bool, t_ns: int) -> None:
        """ENA changed."""
        if on and not self._enabled:
            self._enabled_ns = t_ns
            self._rotor_steps, self._rotor_hz = float(self.position_steps), 0.0
        if not on:
            self.alarm, self._lag_lost = False, 0
        self._enabled = on

    def set_direction(self, high: bool, t_ns: int) -> None:
        """DIR changed."""
        self._sign = self._mounting if high else -self._mounting
        self._turned_ns = t_ns

    def trip(self) -> None:
        """Raise the alarm, as an overcurrent or a lost encoder would."""
        self.alarm = True

    def slip(self, steps: int) -> None:
        """The rotor falls so many steps behind (negative: is pushed ahead) without an alarm."""
        self.position_steps -= steps
        self._rotor_steps -= steps
        self.lost += abs(steps)

    def rise(self, t_ns: int) -> None:
        """STEP went up: this edge counts, if everything is right."""
        self.edges += 1
        limits = self.limits
        late_ok = (
            self._enabled
            and not self.alarm
            and not self.stalled
            and t_ns - self._turned_ns >= limits.direction_setup_ns
            and t_ns - self._fell_ns >= limits.low_ns
            and t_ns - self._enabled_ns >= limits.enable_ns
        )
        self._rose_ns = t_ns
        if late_ok and self._follows(t_ns):
            self._counted = self._sign
            self.position_steps += self._sign
        else:
            self._counted = 0
            self.lost += 1

    def fall(self, t_ns: int) -> None:
        """STEP went down: a pulse too short to pass the input filter never was one."""
        self._fell_ns = t_ns
        if self._counted and t_ns - self._rose_ns < self.limits.pulse_ns:
            self.position_steps -= self._counted
            self.lost += 1
        self._counted = 0

    def _follows(self, t_ns: int) -> bool:
        """Move the rotor towards the command with its limits; whether it stays in step."""
        limits = self.limits
        dt_s = (t_ns - self._rotor_ns) * 1e-9
        self._rotor_ns = t_ns
        bend_hz = limits.acceleration_hz_per_s * dt_s
        wanted_hz = (self.position_steps - self._rotor_steps) / dt_s if dt_s > 0.0 else 0.0
        rotor_hz = self._rotor_hz
        rotor_hz = min(max(wanted_hz, rotor_hz - bend_hz), rotor_hz + bend_hz)
        rotor_hz = self._rotor_hz = min(max(rotor_hz, -limits.speed_hz), limits.speed_hz)
        self._rotor_steps += rotor_hz * dt_s
        if abs(self.position_steps + self._sign - self._rotor_steps) <= limits.lag_steps:
            return True
        self._lag_lost += 1
        self.alarm = self._lag_lost >= limits.following_error_steps
        return False
