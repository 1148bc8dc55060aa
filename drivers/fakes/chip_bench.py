"""One simulated VL53L1X on its own bus, poked register by register: for tests and exploring."""

from __future__ import annotations

import errno

from smbus2 import i2c_msg

from deltactl.drivers.fakes.i2c_bus import FakeI2cBus
from deltactl.drivers.fakes.range_noise import RangeNoise
from deltactl.drivers.fakes.vl53l1x_chip import Vl53l1xChip
from deltactl.foundation.clock import VirtualClock, ns

NO_NOISE = RangeNoise(sigma_m=0.0)


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
