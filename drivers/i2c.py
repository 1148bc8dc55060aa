"""The I2C seam: a bus is anything with smbus2's `i2c_rdwr`, a chip is reached by 16-bit registers.

One call of `i2c_rdwr` is one transaction (repeated start between its messages), so the index
of a register and the bytes read from there cannot be separated. `read_i2c_block_data` cannot
be used: its command byte has 8 bits.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import os
from typing import Protocol

from smbus2 import SMBus, i2c_msg

from deltactl.foundation.clock import Clock
from deltactl.foundation.errors import BusDead

TRANSIENT_ERRNOS = (errno.EREMOTEIO, errno.ETIMEDOUT, errno.EIO)
"""Not acknowledged (121), timed out (110), I/O error (5): what a disturbed bus gives."""

I2C_TIMEOUT_IOCTL = 0x0702
"""linux/i2c-dev.h: set the adapter's timeout, in units of 10 ms (the default is a second)."""
ADAPTER_TIMEOUT_10MS = 3
RETRY_WINDOW_NS = 10_000_000
"""Nothing is tried again once a transfer has taken this long: polls must stay short."""


class I2cBus(Protocol):
    """What the drivers need of a bus; `smbus2.SMBus` and `FakeI2cBus` both have it."""

    def i2c_rdwr(self, *i2c_msgs: i2c_msg) -> None:
        """One transaction of these messages. Raises OSError with the kernel's errno."""

    def close(self) -> None:
        """Give the bus back."""


class Registers:
    """Chip registers with 16-bit big-endian indices, read and written with bounded retries.

    Raises OSError with the kernel's errno when the last try failed too.
    """

    def __init__(self, bus: I2cBus, clock: Clock, address: int, retries: int):
        self.address = address
        self._bus = bus
        self._clock = clock
        self._retries = retries
        self.retried = 0
        """How many transfers had to be repeated so far."""

    def read(self, register: int, count: int) -> bytes:
        """`count` bytes from `register` on, in one transaction."""
        index = i2c_msg.write(self.address, register.to_bytes(2, "big"))
        data = i2c_msg.read(self.address, count)
        self._transfer(self._retries, index, data)
        return bytes(data)

    def write(self, register: int, data: bytes) -> None:
        """Write bytes from `register` on, in one transaction."""
        self._transfer(
            self._retries, i2c_msg.write(self.address, register.to_bytes(2, "big") + data)
        )

    def read_int(self, register: int, size: int) -> int:
        """An unsigned big-endian number of `size` bytes."""
        return int.from_bytes(self.read(register, size), "big")

    def write_int(self, register: int, size: int, value: int) -> None:
        """An unsigned big-endian number of `size` bytes."""
        self.write(register, value.to_bytes(size, "big"))

    def answers(self) -> bool:
        """Whether somebody acknowledges this address now (a single try)."""
        try:
            self._transfer(0, i2c_msg.read(self.address, 1))
        except OSError as error:
            if error.errno in TRANSIENT_ERRNOS:
                return False
            raise
        return True

    def _transfer(self, retries: int, *messages: i2c_msg) -> None:
        give_up_ns = self._clock.now_ns() + RETRY_WINDOW_NS
        while True:
            try:
                return self._bus.i2c_rdwr(*messages)
            except OSError as error:
                late = self._clock.now_ns() >= give_up_ns
                if error.errno not in TRANSIENT_ERRNOS or retries <= 0 or late:
                    raise
            retries -= 1
            self.retried += 1


def open_bus(number: int) -> I2cBus:
    """Open /dev/i2c-`number`. Raises BusDead saying what to do when it cannot be opened."""
    try:
        bus = SMBus(number)
    except FileNotFoundError as error:
        raise BusDead(
            f"/dev/i2c-{number} does not exist: enable I2C (dtparam=i2c_arm=on in config.txt)"
            " and restart, or correct ranging.bus in the robot file"
        ) from error
    except PermissionError as error:
        raise BusDead(
            f"/dev/i2c-{number} may not be opened: add the user to the group i2c"
        ) from error
    except OSError as error:
        raise BusDead(f"/dev/i2c-{number} cannot be opened: {os.strerror(error.errno or 0)}") from (
            error
        )
    # A stuck SDA would hold every poll for a second; adapters that refuse keep their default.
    if bus.fd is not None:
        with contextlib.suppress(OSError):
            fcntl.ioctl(bus.fd, I2C_TIMEOUT_IOCTL, ADAPTER_TIMEOUT_10MS)
    return bus
