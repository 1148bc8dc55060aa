"""The sensors of a robot that has none: no bus and no pin is opened, and nothing is read."""

from __future__ import annotations

from drivers.ranging.contract import Reading


class NoSensors:
    """Keeps the contract of `RangingSensors` without any."""

    def start(self) -> None:
        """Nothing to start."""

    def poll(self) -> list[Reading]:
        """Never a sample."""
        return []

    def health(self) -> dict[str, str]:
        """No sensor has any."""
        return {}

    def take_events(self) -> list[str]:
        """Nothing happens to them."""
        return []

    def close(self) -> None:
        """Nothing to give back."""
