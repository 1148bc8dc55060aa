"""`/dev/i2c-N` in front of a bus of chip models: the ioctls of linux/i2c-dev.h.

See syscall_trap.py for how the calls of an unmodified smbus2 get here. Does not model: 10-bit
addresses, I2C_SMBUS, plain read and write, or an adapter's own time-out.
"""

from __future__ import annotations

import errno
import struct
from collections import Counter

from smbus2 import i2c_msg

from deltactl.drivers.fakes.i2c_bus import FakeI2cBus
from deltactl.drivers.fakes.syscall_trap import Memory

I2C_TIMEOUT, I2C_SLAVE, I2C_FUNCS, I2C_RDWR = 0x0702, 0x0703, 0x0705, 0x0707
FUNC_I2C = 0x1
"""I2C_FUNC_I2C of linux/i2c.h: plain transactions, which is all this adapter does."""
MESSAGES_MAX, BYTES_MAX = 42, 8192
"""I2C_RDWR_IOCTL_MAX_MSGS, and the longest message i2c-dev takes."""

_READ_FLAG = 0x0001
_TRANSACTION = struct.Struct("=QI")  # struct i2c_rdwr_ioctl_data: msgs, nmsgs
_MESSAGE = struct.Struct("=HHHxxQ")  # struct i2c_msg: addr, flags, len, buf


class I2cAdapter:
    """A PointingDevice on a FakeI2cBus. `calls` counts the ioctls by number."""

    def __init__(self, bus: FakeI2cBus):
        self.bus = bus
        self.calls: Counter[int] = Counter()
        self.timeout_10ms: int | None = None
        """What I2C_TIMEOUT was set to last."""

    def ioctl_at(self, request: int, argument: int, memory: Memory) -> None:
        """See PointingDevice."""
        self.calls[request] += 1
        if request == I2C_FUNCS:
            memory.write(argument, struct.pack("=Q", FUNC_I2C))
        elif request == I2C_TIMEOUT:
            self.timeout_10ms = argument
        elif request == I2C_RDWR:
            self._transact(argument, memory)
        elif request != I2C_SLAVE:
            raise OSError(errno.ENOTTY, f"ioctl {request:#x}")

    def _transact(self, argument: int, memory: Memory) -> None:
        where, count = _TRANSACTION.unpack(memory.read(argument, _TRANSACTION.size))
        if count > MESSAGES_MAX:
            raise OSError(errno.EINVAL, "too many messages")
        size = _MESSAGE.size
        rows = list(_MESSAGE.iter_unpack(memory.read(where, count * size)))
        if any(length > BYTES_MAX for _, _, length, _ in rows):
            raise OSError(errno.EINVAL, "a message is too long")
        messages = [
            i2c_msg.read(address, length)
            if flags & _READ_FLAG
            else i2c_msg.write(address, memory.read(buffer, length))
            for address, flags, length, buffer in rows
        ]
        self.bus.i2c_rdwr(*messages)
        for (_, flags, _, buffer), message in zip(rows, messages, strict=True):
            if flags & _READ_FLAG:
                memory.write(buffer, bytes(message))
