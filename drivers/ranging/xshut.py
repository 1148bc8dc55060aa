"""XSHUT lines: low holds a sensor in reset, released lets it boot.

A line is anything with `on`, `off` and `close`, a gpiozero `DigitalOutputDevice` for one.
`OpenDrainLine` is the safe way on a robot: breakout boards pull XSHUT up to their own supply,
so the pin only ever drives low or lets go.
"""

from __future__ import annotations

from typing import Any, Protocol


class XshutLine(Protocol):
    """Drives one XSHUT."""

    def off(self) -> None:
        """Hold the sensor in reset."""

    def on(self) -> None:
        """Let the sensor boot."""

    def close(self) -> None:
        """Give the pin back."""


class OpenDrainLine:
    """A gpiozero pin that drives low or floats. Starts low.

    Needs a pull-up on the board; every VL53L1X breakout has one, the bare module has not.
    """

    def __init__(self, factory: Any, number: int):
        """`factory` is a gpiozero pin factory, `number` a BCM number."""
        self._factory = factory
        self._number = number
        factory.reserve_pins(self, number)
        self._pin = factory.pin(number)
        self.off()

    def __repr__(self) -> str:
        return f"OpenDrainLine(GPIO {self._number})"

    def _conflicts_with(self, other: object) -> bool:
        """Asked by gpiozero when something else wants the pin: never share it."""
        return True

    def off(self) -> None:
        """Drive low."""
        self._pin.output_with_state(0)

    def on(self) -> None:
        """Let go."""
        self._pin.input_with_pull("floating")

    def close(self) -> None:
        """Give the pin back, still low: the sensor stays in reset while the program lives."""
        self.off()
        self._factory.release_pins(self, self._number)
