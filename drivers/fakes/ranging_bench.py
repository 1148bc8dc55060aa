"""Three simulated distance sensors wired up as on the robot: chips, bus, mock pins, XSHUT lines.

For tests and benchmarks there are two benches on a virtual clock: one with targets that can be
moved, where time passes only in `run` and `run_until`, and one of a single chip, poked register by
register.
"""

from __future__ import annotations

import errno
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from gpiozero.pins.mock import MockFactory
from smbus2 import i2c_msg

from deltactl.drivers.fakes.i2c_bus import FakeI2cBus
from deltactl.drivers.fakes.mock_pins import connect_xshut
from deltactl.drivers.fakes.vl53l1x_chip import Vl53l1xChip
from deltactl.drivers.fakes.vl53l1x_scene import RangeNoise
from deltactl.drivers.ranging.bank import AXES, SensorBank
from deltactl.drivers.ranging.contract import Reading
from deltactl.drivers.ranging.robot_sensors import OpenDrainLine
from deltactl.drivers.settings import RangingSettings
from deltactl.foundation.clock import NS_PER_S, Clock, VirtualClock, ns

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
    wire_hz: int | None = None,
) -> RangingRig:
    """Wire up three sensors. Each axis has its own sequence of noise (seed, seed + 1, seed + 2).

    `factory` is a gpiozero MockFactory to share with other simulated parts (default: an own one).
    `oscillator_errors` and `wire_hz`: see Vl53l1xChip and FakeI2cBus.
    """
    factory = MockFactory() if factory is None else factory
    chips = {
        axis: Vl53l1xChip(
            clock,
            partial(distance_m, axis),
            replace(noise, seed=noise.seed + index),
            oscillator_errors[index],
        )
        for index, axis in enumerate(AXES)
    }
    bus = FakeI2cBus(clock, list(chips.values()), wire_hz)
    for axis, number in zip(AXES, settings.xshut_pins, strict=True):
        connect_xshut(factory, number, chips[axis].set_xshut)
    lines = tuple(OpenDrainLine(factory, number) for number in settings.xshut_pins)
    closers = (bus.close, *(line.close for line in lines))
    return RangingRig(SensorBank(settings, bus, lines, clock, closers), chips, bus, lines)


TARGETS_M = {"x": 0.30, "y": 0.45, "z": 0.60}
NO_NOISE = RangeNoise(sigma_m=0.0)


class RangingBench:
    """The sensors, not yet started. `true_m` is the distance to the target of each axis."""

    def __init__(
        self,
        settings: RangingSettings | None = None,
        noise: RangeNoise = NO_NOISE,
        **rig_options: Any,
    ):
        """`rig_options` are those of `build_rig`."""
        self.settings = RangingSettings() if settings is None else settings
        self.clock = VirtualClock()
        self.true_m = dict(TARGETS_M)
        self.rig: RangingRig = build_rig(
            self.settings, self.clock, self._distance_m, noise, **rig_options
        )

    @property
    def bank(self) -> SensorBank:
        """The driver."""
        return self.rig.bank

    @property
    def chips(self) -> dict[str, Vl53l1xChip]:
        """The chips by axis."""
        return self.rig.chips

    @property
    def now_s(self) -> float:
        """Time on the virtual clock."""
        return self.clock.now_ns() / NS_PER_S

    def run(self, duration_s: float, period_s: float = 0.02) -> list[Reading]:
        """Poll for a while; all readings that came."""
        readings = []
        until_ns = self.clock.now_ns() + ns(duration_s)
        while self.clock.now_ns() < until_ns:
            self.clock.sleep_until_ns(self.clock.now_ns() + ns(period_s))
            readings += self.bank.poll()
        return readings

    def run_until(self, done: Callable[[], bool], limit_s: float = 10.0) -> float:
        """Poll until something holds; the seconds it took. Raises TimeoutError."""
        start_s = self.now_s
        while not done():
            self.run(0.02)
            if self.now_s - start_s > limit_s:
                raise TimeoutError(f"not within {limit_s:g} s: {self.bank.health()}")
        return self.now_s - start_s

    def well(self) -> bool:
        """Whether all three sensors say ok."""
        return set(self.bank.health().values()) == {"ok"}

    def _distance_m(self, axis: str, start_ns: int, end_ns: int) -> float:
        return self.true_m[axis]


class ChipBench:
    """One chip at 0.5 m, its bus, and register access in the plainest way."""

    def __init__(self, noise: RangeNoise = NO_NOISE, oscillator_error: float = 0.0):
        """`windows` collects the times [ns] over which distances were averaged."""
        self.clock = VirtualClock()
        self.true_m = 0.5
        self.windows: list[tuple[int, int]] = []
        self.chip = Vl53l1xChip(self.clock, self._distance, noise, oscillator_error)
        self.bus = FakeI2cBus(self.clock, [self.chip])
        self.address = 0x29

    def _distance(self, start_ns: int, end_ns: int) -> float:
        self.windows.append((start_ns, end_ns))
        return self.true_m

    def wait(self, seconds: float) -> None:
        """Let time pass."""
        self.clock.sleep_until_ns(self.clock.now_ns() + ns(seconds))

    def read(self, register: int, count: int = 1) -> bytes:
        """Bytes from a register on."""
        data = i2c_msg.read(self.address, count)
        self.bus.i2c_rdwr(i2c_msg.write(self.address, register.to_bytes(2, "big")), data)
        return bytes(data)

    def write(self, register: int, *values: int) -> None:
        """Bytes to a register on."""
        message = [*register.to_bytes(2, "big"), *values]
        self.bus.i2c_rdwr(i2c_msg.write(self.address, message))

    def silent(self) -> bool:
        """Whether nobody acknowledges `address`."""
        try:
            self.read(0x010F)
        except OSError as error:
            return error.errno == errno.EREMOTEIO
        return False

    def set_up(self, budget: tuple[int, int] = (0x0051, 0x006E), period_ms: int = 20) -> None:
        """Short mode's 20 ms as the sheet has it, flag active high, limits as in the block."""
        self.wait(0.002)
        self.write(0x0030, 0x01)
        self.write(0x005E, *budget[0].to_bytes(2, "big"), 0x07)
        self.write(0x0061, *budget[1].to_bytes(2, "big"), 0x05, 0x01, 0x68, 0x00, 0x80)
        self.write(0x0069, 0x38)
        self.write(0x006C, *(39 * period_ms).to_bytes(4, "big"))

    def start(self) -> None:
        """Set up and range."""
        self.set_up()
        self.write(0x0087, 0x40)

    def stream(self) -> int:
        """Stream count."""
        return self.read(0x008B)[0]

    def status(self) -> int:
        """Masked range status."""
        return self.read(0x0089)[0] & 0x1F

    def distance_mm(self) -> int:
        """Distance."""
        return int.from_bytes(self.read(0x0096, 2), "big")

    def flag(self) -> int:
        """Level of the ready flag."""
        return self.read(0x0031)[0] & 1
