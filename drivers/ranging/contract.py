"""The ranging contract: each poll gives the new readings, and says how good each one is."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Protocol


class Gate(enum.Enum):
    """Whether a distance may be used, and if not, why."""

    GOOD = "good"
    STATUS = "status"
    SIGNAL = "signal"
    SIGMA = "sigma"
    JUMP = "jump"


@dataclass(frozen=True, slots=True)
class Reading:
    """One sample of one sensor.

    `t_ns` is the middle of the time over which light was collected, on the clock of the run.
    `status` is the ULD code (0 = valid), `raw_status` the chip's own (masked with 0x1F).
    """

    axis: str
    t_ns: int
    distance_m: float
    status: int
    raw_status: int
    signal_mcps: float
    ambient_mcps: float
    sigma_m: float
    stream_count: int
    gate: Gate


class RangingSensors(Protocol):
    """Reads three distances at their own pace and restarts one sensor while the others go on."""

    def start(self) -> None:
        """Reset, address and configure all sensors. Raises BusDead or SensorFault."""

    def poll(self) -> list[Reading]:
        """New samples since the last poll. Raises BusDead, or SensorFault when restarts fail."""

    def health(self) -> dict[str, str]:
        """Per axis 'ok', 'restarting' or what is wrong, for status and events."""

    def take_events(self) -> list[str]:
        """What happened since the last call: restarts, brown-outs, advice; one line each."""

    def close(self) -> None:
        """Stop ranging and hold the sensors in reset."""


class NoSensors:
    """The sensors of a robot that has none: no bus and no pin is opened, and nothing is read."""

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
