"""The ioctls of i2c-dev as the modelled adapter answers them, without a kernel between."""

from __future__ import annotations

import errno
import struct

import pytest

from deltactl.drivers.fakes.i2c_bus import (
    FUNC_I2C,
    I2C_FUNCS,
    I2C_RDWR,
    I2C_SLAVE,
    I2C_TIMEOUT,
    I2cAdapter,
)
from deltactl.drivers.fakes.ranging_bench import ChipBench

MODEL_ID = b"\xea\xcc"


class Memory:
    """A child's memory, from address 0 on."""

    def __init__(self) -> None:
        self.data = bytearray(4096)

    def read(self, address: int, count: int) -> bytes:
        return bytes(self.data[address : address + count])

    def write(self, address: int, data: bytes) -> None:
        self.data[address : address + len(data)] = data


def transaction(memory: Memory, *messages: tuple[int, int, int, int], count: int = 0) -> int:
    """Lay out i2c_rdwr_ioctl_data at 0 and its messages (address, flags, length, buffer)."""
    memory.write(0, struct.pack("=QI", 64, count or len(messages)))
    for index, message in enumerate(messages):
        memory.write(64 + 16 * index, struct.pack("=HHHxxQ", *message))
    return 0


@pytest.fixture
def bench() -> ChipBench:
    made = ChipBench()
    made.wait(0.002)
    return made


def test_a_register_is_read_in_one_transaction(bench: ChipBench) -> None:
    adapter, memory = I2cAdapter(bench.bus), Memory()
    memory.write(1000, (0x010F).to_bytes(2, "big"))
    where = transaction(memory, (0x29, 0, 2, 1000), (0x29, 1, 2, 2000))
    adapter.ioctl_at(I2C_RDWR, where, memory)
    assert memory.read(2000, 2) == MODEL_ID
    assert adapter.calls[I2C_RDWR] == 1


def test_what_else_smbus2_asks(bench: ChipBench) -> None:
    adapter, memory = I2cAdapter(bench.bus), Memory()
    adapter.ioctl_at(I2C_FUNCS, 100, memory)
    adapter.ioctl_at(I2C_TIMEOUT, 3, memory)
    adapter.ioctl_at(I2C_SLAVE, 0x29, memory)
    assert struct.unpack("=Q", memory.read(100, 8)) == (FUNC_I2C,)
    assert adapter.timeout_10ms == 3


@pytest.mark.parametrize(
    ("message", "count", "number"),
    [
        ((0x30, 1, 1, 2000), 1, errno.EREMOTEIO),  # nobody there
        ((0x29, 1, 1, 2000), 43, errno.EINVAL),
        ((0x29, 1, 8193, 2000), 1, errno.EINVAL),
    ],
)
def test_the_kernels_errors(bench: ChipBench, message, count: int, number: int) -> None:
    adapter, memory = I2cAdapter(bench.bus), Memory()
    with pytest.raises(OSError, match="Errno") as caught:
        adapter.ioctl_at(I2C_RDWR, transaction(memory, message, count=count), memory)
    assert caught.value.errno == number


def test_an_ioctl_it_does_not_have(bench: ChipBench) -> None:
    with pytest.raises(OSError, match="ioctl 0x720") as caught:
        I2cAdapter(bench.bus).ioctl_at(0x0720, 0, Memory())
    assert caught.value.errno == errno.ENOTTY
