"""The contract of three current-commanded drives: set a current, read an encoder.

What a servo amplifier in current mode offers on any fieldbus. It knows no position loop and no
reference: those belong to firmware_py/servo.
"""

from __future__ import annotations

from typing import Protocol

JOINTS = 3
Counts = tuple[int, int, int]
Three = tuple[float, float, float]


class CurrentDrives(Protocol):
    """Three drives, called once a control period: read, then set.

    A drive that trips says so in `read_counts` and in `set_currents_a`; whoever gets that must
    `make_safe`. Only `clear` takes a trip back, and only when its cause is gone.
    """

    def enable(self) -> None:
        """Let current flow and lift the brakes. Raises DriveAlarm naming a tripped joint."""

    def make_safe(self) -> None:
        """Currents to zero, brakes (where there are any) on. Never raises; may be repeated."""

    def read_counts(self) -> Counts:
        """Encoder counts of the three joints, signed; count 0 is where they were `set_counts`.

        Raises DriveAlarm naming the joint ('motor2') whose signal is lost or that has tripped.
        """

    def set_currents_a(self, first: float, second: float, third: float) -> None:
        """Motor currents [A] from now on; beyond its limit a drive gives its limit.

        Positive current turns towards positive angles. Raises DriveAlarm as `read_counts` does,
        ValueError for a current that is no number.
        """

    def set_counts(self, counts: Counts) -> None:
        """Say where the joints are (homing)."""

    def clear(self) -> None:
        """Take trips back. Raises DriveAlarm while a cause is still there."""

    def close(self) -> None:
        """Make safe and give the drives back."""


class Plant(Protocol):
    """What a simulated robot is behind fake drives: torque at the rotors in, angles out.

    One call is one control period. Any simulation that has these may replace another.
    """

    def advance(self, first: float, second: float, third: float) -> None:
        """Go on by one control period with these motor currents held [A]."""

    def hold(self) -> None:
        """Go on by one control period with the brakes on."""

    def place(self, angles_rad: Three) -> None:
        """Put the arms at these true angles, at rest (the hands of an operator)."""

    def angles_rad(self) -> Three:
        """True arm angles at the shaft, 0 = horizontal, positive = down [rad]."""
