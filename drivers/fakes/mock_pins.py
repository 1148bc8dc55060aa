"""gpiozero's mock pins as ends of wires: the circuit hears the program, and the program it.

gpiozero's own MockPin remembers every change for ever and resets an input to its pull; these
remember the level only, and a driven wire wins over a pull.

A home switch with its wire is closed while its arm is at home or above, unless something is wrong.
Models: contacts that stick, late closing that differs from time to time, bounce, readings that are
false by chance or at a given moment (a pulse from a motor's cable), and exchanged wires. Does not
model: the way a lever needs to open again (hysteresis), or a pin's voltage.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from gpiozero.pins.mock import MockFactory, MockPin

OnLevel = Callable[[bool], None]


class WiredPin(MockPin):  # type: ignore[misc]
    """A pin with something connected. Does not model: drive strength, or two drivers on a wire."""

    def __init__(self, factory: WiredFactory, info: Any):
        self._state: bool
        self.driven: bool | None = None
        self.on_level: OnLevel | None = None
        super().__init__(factory, info)

    def drive(self, level: bool | None) -> None:
        """The circuit puts a level on the wire, or leaves it to the pull resistor (None)."""
        self.driven = level
        if self.function == "input":
            self._settle()

    def clear_states(self) -> None:
        """Keep no history (gpiozero's grows without limit)."""
        self._last_change = 0.0
        self.states: list[Any] = []

    def _change_state(self, value: bool) -> bool:
        if self._state == value:
            return False
        self._state = value
        self._last_change = self.factory.ticks()
        if self.on_level is not None and self._function == "output":
            self.on_level(value)
        return True

    def _set_function(self, value: str) -> None:
        super()._set_function(value)
        if value == "output" and self.on_level is not None:
            self.on_level(self._state)

    def _set_pull(self, value: str) -> None:
        if self.driven is None:
            super()._set_pull(value)
        else:
            self._pull = value
            self._settle()

    def _settle(self) -> None:
        pulled_up = self._pull == "up"
        if pulled_up if self.driven is None else self.driven:
            self.drive_high()
        else:
            self.drive_low()


class WiredFactory(MockFactory):  # type: ignore[misc]
    """A pin factory for a Raspberry Pi 4B whose pins are WiredPins; give it as `pin_factory=`."""

    def __init__(self) -> None:
        super().__init__(revision="c03111", pin_class=WiredPin)

    def connect(self, pin: int, on_level: OnLevel) -> None:
        """Call `on_level` when the program puts a level on this pin (BCM number)."""
        self.pin(pin).on_level = on_level

    def drive(self, pin: int, level: bool | None) -> None:
        """A switch or chip puts a level on this pin, or lets it go (None)."""
        self.pin(pin).drive(level)


class XshutPin(MockPin):  # type: ignore[misc]  # gpiozero has no types
    """Driven it has the level written, as an input the board pulls it up.

    `on_level` is called with every change of level. Does not model: rise times, or the Pi's
    own pull resistors (50 kOhm against the board's 10 kOhm).
    """

    def __init__(self, factory: Any, info: Any, on_level: Callable[[bool], None]):
        self.on_level: Callable[[bool], None] = lambda level: None
        super().__init__(factory, info)
        self._pull_up()
        self.on_level = on_level
        on_level(True)

    def _set_function(self, value: str) -> None:
        super()._set_function(value)
        self._pull_up()

    def _set_pull(self, value: str) -> None:
        super()._set_pull(value)
        self._pull_up()

    def _change_state(self, value: bool) -> bool:
        changed = bool(super()._change_state(value))
        if changed:
            self.clear_states()  # gpiozero's history grows with every switching on, for ever
            self.on_level(bool(value))
        return changed

    def _pull_up(self) -> None:
        if self._function == "input":
            self._change_state(True)


def connect_xshut(factory: Any, number: int, on_level: Callable[[bool], None]) -> XshutPin:
    """Put a sensor's XSHUT on a BCM pin of a gpiozero MockFactory; tells it the level at once."""
    pin: XshutPin = factory.pin(number, pin_class=XshutPin, on_level=on_level)
    return pin


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
