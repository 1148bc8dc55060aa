"""A home switch with its wire: closed while its arm is at home or above, unless something is wrong.

Models: contacts that stick, late closing that differs from time to time, bounce, readings that
are false by chance or at a given moment (a pulse from a motor's cable), and exchanged wires.

Does not model: the way a lever needs to open again (hysteresis), or a pin's voltage.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field


@dataclass
class SwitchFaults:
    """Knobs, all off at first; may be turned at any time. `clear` turns all off again."""

    stuck: bool | None = None
    """Always closed (True) or open (False)."""
    false_rate: float = 0.0
    """Part of the readings that say the opposite."""
    false_at: frozenset[int] = frozenset()
    """Numbers of single readings (the first is 1) that say the opposite."""
    late_rad: Sequence[float] = ()
    """How far above home it closes: the first time, the second, and so on; the last one stays."""
    bounces: int = 0
    """While closed, every reading of so many is an open one; 0 is none."""
    seed: int = 1

    def clear(self) -> None:
        """Turn all knobs off."""
        self.__dict__.update(SwitchFaults().__dict__)


@dataclass
class FakeHomeSwitch:
    """Called, it is what the program reads from the pin: whether the switch is closed."""

    above_rad: Callable[[], float]
    """How far its arm is above home now; a wire that is exchanged is another arm's."""
    faults: SwitchFaults = field(default_factory=SwitchFaults)
    readings: int = 0
    """How often it was read."""
    _closed: bool = False
    _closings: int = 0
    _chance: random.Random | None = None

    def __call__(self) -> bool:
        """One reading."""
        self.readings += 1
        faults = self.faults
        if faults.stuck is not None:
            return faults.stuck
        closed = self._contact()
        if closed and faults.bounces and self.readings % faults.bounces == 0:
            return False
        if self.readings in faults.false_at or self._false():
            return not closed
        return closed

    def _contact(self) -> bool:
        late_rad = self.faults.late_rad
        after_rad = late_rad[min(self._closings, len(late_rad) - 1)] if late_rad else 0.0
        above_rad = self.above_rad()
        if self._closed and above_rad < 0.0:
            self._closed = False
            self._closings += 1
        elif not self._closed and above_rad >= after_rad:
            self._closed = True
        return self._closed

    def _false(self) -> bool:
        if self.faults.false_rate <= 0.0:
            return False
        if self._chance is None:
            self._chance = random.Random(self.faults.seed)
        return self._chance.random() < self.faults.false_rate


def exchange(first: FakeHomeSwitch, second: FakeHomeSwitch) -> None:
    """Exchange the wires of two switches."""
    first.above_rad, second.above_rad = second.above_rad, first.above_rad
