"""A mock pin with the XSHUT of a simulated sensor on it, and the pull-up of its breakout board."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from gpiozero.pins.mock import MockPin


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
