"""Outputs that jobs switch, as bits: which pin levels they mean, and which are safe.

They belong to whoever owns the step lines, so that the process that stops the motors when the
e-stop opens, an alarm comes or the controller is gone puts them to their safe state as well.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from deltactl.drivers.settings import SwitchedPin
from deltactl.drivers.steps.lines import SWITCH_SHIFT


@dataclass(frozen=True, slots=True)
class Switches:
    """Named outputs in the order of their bits, the first at SWITCH_SHIFT."""

    pins: Mapping[str, SwitchedPin]

    @property
    def numbers(self) -> list[int]:
        """GPIO numbers."""
        return [one.pin for one in self.pins.values()]

    @property
    def mask(self) -> int:
        """Bits of all of them, as lines have them."""
        return ((1 << len(self.pins)) - 1) << SWITCH_SHIFT

    @property
    def safe_levels(self) -> int:
        """Pin levels of the safe state, as lines have them."""
        return self.levels({name: one.safe for name, one in self.pins.items()})[0]

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
