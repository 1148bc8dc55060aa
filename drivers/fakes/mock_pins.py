"""gpiozero's mock pins as ends of wires: the circuit hears the program, and the program it.

gpiozero's own MockPin remembers every change for ever and resets an input to its pull; these
remember the level only, and a driven wire wins over a pull.
"""

from __future__ import annotations

from collections.abc import Callable
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
