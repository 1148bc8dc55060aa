"""The seam between player and pins: write the bits of a mask at once, read the inputs.

Levels are what a meter would show on the pin; which level means what is the player's affair.
Outputs that jobs switch belong to whoever owns the step lines, so that the process that stops the
motors when the e-stop opens, an alarm comes or the controller is gone puts them to their safe
state as well. This file is loaded by the pulse process.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

from deltactl.drivers.settings import SwitchedPin

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


@dataclass(frozen=True, slots=True)
class Switches:
    """Named outputs in the order of their bits, the first at SWITCH_SHIFT."""

    pins: Mapping[str, SwitchedPin]

    @property
    def numbers(self) -> list[int]:
        """GPIO numbers."""
        return [output.pin for output in self.pins.values()]

    @property
    def mask(self) -> int:
        """Bits of all of them, as lines have them."""
        return ((1 << len(self.pins)) - 1) << SWITCH_SHIFT

    @property
    def safe_levels(self) -> int:
        """Pin levels of the safe state, as lines have them."""
        return self.levels({name: output.safe for name, output in self.pins.items()})[0]

    def levels(self, on: Mapping[str, bool]) -> tuple[int, int]:
        """Pin levels that put some outputs on or off, and the mask of those."""
        levels = mask = 0
        for place, (name, pin) in enumerate(self.pins.items(), SWITCH_SHIFT):
            if name in on:
                mask |= 1 << place
                levels |= int(pin.level(on[name])) << place
        return levels, mask

    def states(self, levels: int) -> dict[str, bool]:
        """Which are on at these pin levels."""
        return {
            name: bool(levels >> place & 1) == pin.active_high
            for place, (name, pin) in enumerate(self.pins.items(), SWITCH_SHIFT)
        }


NO_SWITCHES = Switches({})
