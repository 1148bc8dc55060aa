"""Three simulated sensors wired up as on the robot: chips, bus, mock pins and the XSHUT lines."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from gpiozero.pins.mock import MockFactory

from deltactl.drivers.fakes.i2c_bus import FakeI2cBus
from deltactl.drivers.fakes.range_noise import RangeNoise
from deltactl.drivers.fakes.vl53l1x_chip import Vl53l1xChip
from deltactl.drivers.fakes.xshut_pin import connect_xshut
from deltactl.drivers.ranging.bank import AXES, SensorBank
from deltactl.drivers.ranging.xshut import OpenDrainLine
from deltactl.drivers.settings import RangingSettings
from deltactl.foundation.clock import Clock

DistanceAlong = Callable[[str, int, int], float]
"""(axis, from_ns, to_ns) -> true distance [m] averaged over that time."""


@dataclass(frozen=True)
class RangingRig:
    """The parts of the simulated sensors; `bank` is the same driver as on the robot."""

    bank: SensorBank
    chips: dict[str, Vl53l1xChip]
    bus: FakeI2cBus
    lines: tuple[OpenDrainLine, ...]


def build_rig(
    settings: RangingSettings,
    clock: Clock,
    distance_m: DistanceAlong,
    noise: RangeNoise = RangeNoise(),  # noqa: B008 (immutable)
    factory: Any = None,
    oscillator_errors: tuple[float, float, float] = (0.0, 0.0, 0.0),
    bus_clock_hz: int = 400_000,
    bus_takes_time: bool = False,
) -> RangingRig:
    """Wire up three sensors. Each axis has its own sequence of noise (seed, seed + 1, seed + 2).

    `factory` is a gpiozero MockFactory to share with other simulated parts (default: an own one).
    `oscillator_errors`, `bus_clock_hz` and `bus_takes_time`: see Vl53l1xChip and FakeI2cBus.
    """
    factory = MockFactory() if factory is None else factory
    chips = {
        axis: Vl53l1xChip(
            clock,
            _along(distance_m, axis),
            replace(noise, seed=noise.seed + index),
            oscillator_errors[index],
        )
        for index, axis in enumerate(AXES)
    }
    bus = FakeI2cBus(clock, list(chips.values()), bus_clock_hz, bus_takes_time)
    for axis, number in zip(AXES, settings.xshut_pins, strict=True):
        connect_xshut(factory, number, chips[axis].set_xshut)
    lines = tuple(OpenDrainLine(factory, number) for number in settings.xshut_pins)
    closers = (bus.close, *(line.close for line in lines))
    return RangingRig(SensorBank(settings, bus, lines, clock, closers), chips, bus, lines)


def _along(distance_m: DistanceAlong, axis: str) -> Callable[[int, int], float]:
    def over(start_ns: int, end_ns: int) -> float:
        return distance_m(axis, start_ns, end_ns)

    return over
