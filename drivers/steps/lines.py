"""The seam between player and pins: write the bits of a mask at once, read the inputs.

Levels are what a meter would show on the pin; which level means what is the player's affair.
"""

from __future__ import annotations

from typing import Protocol

STEP_BITS = 0b000_0111
"""STEP of motor 1 (bit 0) to motor 3 (bit 2)."""
DIRECTION_SHIFT = 3
DIRECTION_BITS = 0b011_1000
ENABLE_BIT = 0b100_0000
OUTPUT_LINES = 7
SWITCH_SHIFT = OUTPUT_LINES
"""From this bit on: outputs that jobs switch (a gripper, a valve), in the robot file's order."""
MOST_SWITCHES = 8

ESTOP_BIT = 0b0001
ALARM_SHIFT = 1
ALARM_BITS = 0b1110
"""ALM of motor 1 (bit 1) to motor 3 (bit 3)."""


class LineGroup(Protocol):
    """Output and input lines of one robot. Errors of the hardware are OSError."""

    def write(self, levels: int, mask: int) -> None:
        """Set the output lines whose bit is in `mask` to their bit in `levels`."""

    def read(self) -> int:
        """Levels of the input lines; a line that does not exist may read as anything."""

    def close(self) -> None:
        """Give the lines back."""
