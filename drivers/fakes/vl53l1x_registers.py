"""The register file of the VL53L1X model: reset values, what is read-only, and the pointer.

Written from the same facts sheet as the driver but not from the driver's tables, so that a
wrong register there is not also wrong here.
"""

from __future__ import annotations

SPACE = 0x0200
"""Registers 0x0000 to 0x01FF; others read 0 and ignore writes."""

RESET_VALUES: dict[int, bytes] = {
    0x0001: bytes([0x29]),  # I2C address
    0x0006: bytes([0xBC, 0xCC]),  # fast oscillator, 11.8 MHz in 4.12
    0x0030: bytes([0x11]),  # flag active low
    0x0031: bytes([0x02]),  # fresh out of reset
    0x007F: bytes([199]),  # ROI centre
    0x0080: bytes([0xFF]),  # ROI 16 x 16
    0x00DE: bytes([0x00, 0x27]),  # slow oscillator: 39 periods a millisecond
    0x00E5: bytes([0x02]),  # not booted
    0x010F: bytes([0xEA, 0xCC, 0x10]),  # model, type, revision
    0x013E: bytes([199, 0xFF]),  # optical centre and size, from the factory
}

READ_ONLY = (range(0x0088, 0x0100), range(0x010F, 0x0112), range(0x013E, 0x0140))
"""Results and firmware status, identity, factory values."""

I2C_ADDRESS = 0x0001
FAST_OSC = 0x0006
SLOW_OSC = 0x00DE
FLAG_POLARITY = 0x0030
FLAG = 0x0031
FIRMWARE_STATUS = 0x00E5
MODEL_ID = 0x010F
TIMEOUT_A, PERIOD_A = 0x005E, 0x0060
TIMEOUT_B, PERIOD_B = 0x0061, 0x0063
SIGMA_LIMIT, SIGNAL_LIMIT, PHASE_LIMIT = 0x0064, 0x0066, 0x0069
INTER_MEASUREMENT = 0x006C
HOLD = 0x0082
INTERRUPT_CLEAR = 0x0086
MODE_START = 0x0087
INTERRUPT_STATUS = 0x0088
RESULTS = 0x0089


class RegisterFile:
    """Bytes behind a 16-bit pointer that moves on with every byte and stays between messages."""

    def __init__(self) -> None:
        self._bytes = bytearray(SPACE)
        self._pointer = 0
        self.reset()

    def reset(self) -> None:
        """Back to the reset values."""
        self._bytes[:] = bytes(SPACE)
        self._pointer = 0
        for index, values in RESET_VALUES.items():
            self.put(index, values)

    def get(self, index: int, size: int) -> int:
        """A big-endian number."""
        return int.from_bytes(self._bytes[index : index + size], "big")

    def put(self, index: int, values: bytes) -> None:
        """Set bytes from inside the chip, read-only or not."""
        self._bytes[index : index + len(values)] = values

    def point(self, index: int) -> None:
        """Where the next read or write starts."""
        self._pointer = index

    def read(self, count: int) -> bytes:
        """Bytes from the pointer on, as the bus reads them."""
        start, self._pointer = self._pointer, (self._pointer + count) & 0xFFFF
        return bytes(self._bytes[start : start + count]).ljust(count, b"\0")

    def write(self, values: bytes) -> list[tuple[int, int]]:
        """Bytes from the pointer on, as the bus writes them; gives (index, value) of those kept."""
        kept = []
        for value in values:
            index, self._pointer = self._pointer, (self._pointer + 1) & 0xFFFF
            if index < SPACE and not any(index in closed for closed in READ_ONLY):
                self._bytes[index] = value
                kept.append((index, value))
        return kept
