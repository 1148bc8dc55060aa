"""A bus of chip models behind the interface of `smbus2.SMBus`, for real `i2c_msg` objects; and
`/dev/i2c-N` in front of it: the ioctls of linux/i2c-dev.h.

Models: acknowledge by address, several chips at one address (all take what is written, what they
send is ANDed: open drain), errno as the kernel gives it, a stuck bus, and on request the time
that the bits take on the wire.

Does not model: clock stretching, arbitration, SMBus commands (only `i2c_rdwr` is there), how
long a real adapter waits before it reports a time-out; of the device, 10-bit addresses,
I2C_SMBUS, plain read and write. See syscall_trap.py for how the calls of an unmodified smbus2 get
to the device.
"""

from __future__ import annotations

import ctypes
import errno
import os
import struct
import threading
from collections import Counter
from collections.abc import Sequence

from smbus2 import i2c_msg

from deltactl.drivers.fakes.syscall_trap import Memory
from deltactl.drivers.fakes.vl53l1x_chip import Vl53l1xChip
from deltactl.foundation.clock import NS_PER_S, Clock, sleep_s

_READ_FLAG = 0x0001
"""I2C_M_RD of linux/i2c.h."""


class FakeI2cBus:
    """The bus. Set `stuck` to make every transfer time out, `gone` to take the adapter away,
    `hang_s` to have the next one not come back for so long."""

    def __init__(
        self,
        clock: Clock,
        chips: Sequence[Vl53l1xChip],
        wire_hz: int | None = None,
    ):
        """wire_hz: every transfer advances the clock by its bits at this rate; None: by nothing."""
        self.chips = list(chips)
        self.stuck = False
        self.gone = False
        self.hang_s = 0.0
        """So long the next transfer does not come back, as with a stretched clock."""
        self.transfers = 0
        """How many transfers were tried."""
        self._clock = clock
        self._ns_per_bit = NS_PER_S / wire_hz if wire_hz else 0.0
        self._lock = threading.RLock()
        self._open = True

    def __enter__(self) -> FakeI2cBus:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close; transfers then fail as on a closed descriptor."""
        self._open = False

    def i2c_rdwr(self, *i2c_msgs: i2c_msg) -> None:
        """One transaction. Raises OSError with the kernel's errno."""
        with self._lock:
            self.transfers += 1
            hang_s, self.hang_s = self.hang_s, 0.0
            if hang_s:
                sleep_s(self._clock, hang_s)
            failure, bits = self._transfer(i2c_msgs)
            if self._ns_per_bit:
                wire_ns = round(bits * self._ns_per_bit)
                self._clock.sleep_until_ns(self._clock.now_ns() + wire_ns)
        if failure is not None:
            raise OSError(failure, os.strerror(failure))

    def _transfer(self, messages: Sequence[i2c_msg]) -> tuple[int | None, int]:
        """Carry out the messages; (errno or None, bits on the wire)."""
        failure, bits = self._blocked(), 1
        for count, message in enumerate(messages):
            address = message.addr
            chips = [] if failure else [c for c in self.chips if c.answers(address)]
            if chips and count == 0:
                failure = self._disturbed(chips)
            if failure or not chips:
                return failure or errno.EREMOTEIO, bits + 9
            self._message(message, chips)
            bits += 9 * (1 + message.len)
        return None, bits

    def _blocked(self) -> int | None:
        """The errno of a bus on which nothing can be said at all."""
        if not self._open:
            return errno.EBADF
        if self.gone:
            return errno.ENODEV
        if self.stuck:
            return errno.ETIMEDOUT
        return errno.ETIMEDOUT if any(chip.holds_sda for chip in self.chips) else None

    def _disturbed(self, addressed: Sequence[Vl53l1xChip]) -> int | None:
        """The errno that the faults of the chips give; one undisturbed chip is enough to go on."""
        failures = [chip.faults.transfer_errno() for chip in addressed]
        return failures[0] if None not in failures else None

    def _message(self, message: i2c_msg, chips: Sequence[Vl53l1xChip]) -> None:
        if message.flags & _READ_FLAG:
            data = chips[0].read(message.len)
            for other in chips[1:]:
                data = bytes(a & b for a, b in zip(data, other.read(message.len), strict=True))
            block = ctypes.c_char * message.len
            # Not memmove, which lets go of the interpreter: some other thread then has its turn.
            block.from_address(ctypes.addressof(message.buf.contents)).raw = data
        else:
            data = message.buf[: message.len]
            for chip in chips:
                chip.write(data)


I2C_TIMEOUT, I2C_SLAVE, I2C_FUNCS, I2C_RDWR = 0x0702, 0x0703, 0x0705, 0x0707
FUNC_I2C = 0x1
"""I2C_FUNC_I2C of linux/i2c.h: plain transactions, which is all this adapter does."""
MESSAGES_MAX, BYTES_MAX = 42, 8192
"""I2C_RDWR_IOCTL_MAX_MSGS, and the longest message i2c-dev takes."""

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
