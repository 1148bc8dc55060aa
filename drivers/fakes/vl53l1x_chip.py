"""A VL53L1X at register level, driven by a clock: the part below smbus2 and an XSHUT pin.

Models: boot after XSHUT (not acknowledging), the address register, 0x29 and reset values after
a brown-out, grouped-parameter hold, timed and single ranging at max(range time from the timeout
registers, inter-measurement period), stream count, the ready flag with its polarity, status
codes from the chip's own limits, and the fault knobs of `ChipFaults`.

Does not model: the firmware's own algorithms (VHV, phase and SPAD calibration take no part in
the result), interrupt thresholds, ROI, crosstalk and offset registers, or the extra range
that some parts need when period and budget are nearly equal.

Written from the same facts sheet as the driver but not from the driver's tables, so that a wrong
register there is not also wrong here.
"""

from __future__ import annotations

import struct
from collections.abc import Callable

from deltactl.drivers.fakes.vl53l1x_scene import (
    SPADS,
    ChipFaults,
    Limits,
    RangeNoise,
    Scene,
    Seen,
    look,
)
from deltactl.foundation.clock import Clock

DistanceOver = Callable[[int, int], float]
"""True distance [m] averaged from one time to another [ns]; nan or inf when there is no target."""

BOOT_NS = 1_200_000
OVERHEAD_US = 4528.0
TIMED, SINGLE, BACK_TO_BACK = 0x40, 0x10, 0x20
_RESULTS = struct.Struct(">BBBHHHHHHH")


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


class Vl53l1xChip:
    """One chip. The bus calls `answers`, `write` and `read`; the pin calls `set_xshut`.

    `noise` applies at nominal light. `oscillator_error` is how much slower than nominal
    the chip's clock runs (0.01: everything takes 1 % longer).
    """

    def __init__(
        self,
        clock: Clock,
        distance_m: DistanceOver,
        noise: RangeNoise = RangeNoise(),  # noqa: B008 (immutable)
        oscillator_error: float = 0.0,
        xshut_high: bool = True,
    ):
        self.faults = ChipFaults()
        self.scene = Scene()
        self.address = 0
        """7-bit address it answers at."""
        self.samples = 0
        """How many samples it has made since the model was built."""
        self._clock = clock
        self._distance_m = distance_m
        self._noise = noise.source()
        self._slowness = 1.0 + oscillator_error
        self._registers = RegisterFile()
        self._xshut_high = xshut_high
        self._booted_ns = self._firmware_ns = 0
        self._firmware_up = False
        self._mode = self._next_ready_ns = self._period_ns = self._collection_ns = 0
        self._stream: int | None = None
        self._shown_m = 0.0
        self._reset()

    # The pin and the supply.

    def set_xshut(self, high: bool) -> None:
        """The level of XSHUT: low holds in reset, the rising edge boots."""
        if high == self._xshut_high:
            return
        self._xshut_high = high
        if not self.faults.xshut_broken:
            self._reset()

    def brown_out(self) -> None:
        """The supply dips: back to 0x29 and the reset values, boots by itself."""
        self._reset()

    @property
    def ranging(self) -> bool:
        """Whether it makes samples."""
        return self._mode != 0

    @property
    def holds_sda(self) -> bool:
        """Whether it blocks the bus."""
        return self.faults.sda_stuck

    # The bus.

    def answers(self, address: int) -> bool:
        """Whether it acknowledges this address now."""
        if address != self.address or self.faults.unpowered or not self._running:
            return False
        now_ns = self._clock.now_ns()
        if now_ns < self._booted_ns:
            return False
        self._catch_up(now_ns)
        return True

    def write(self, data: bytes) -> None:
        """A write message: index (two bytes), then values."""
        if len(data) < 2:
            return
        self._registers.point(int.from_bytes(data[:2], "big"))
        for index, value in self._registers.write(data[2:]):
            self._react(index, value)

    def read(self, count: int) -> bytes:
        """A read message."""
        return self.faults.disturb(self._registers.read(count))

    # Inside.

    @property
    def _running(self) -> bool:
        return self._xshut_high or self.faults.xshut_broken

    def _reset(self) -> None:
        self._registers.reset()
        self.address = self._registers.get(I2C_ADDRESS, 1)
        self._firmware_up = False
        self._mode = 0
        self._stream = None
        self.faults.sda_stuck = False
        self._booted_ns = self._clock.now_ns() + BOOT_NS + self.faults.extra_boot_ns
        self._firmware_ns = self._booted_ns + self.faults.deaf_firmware_ns

    def _catch_up(self, now_ns: int) -> None:
        """Bring the registers up to date; called before every message."""
        if not self._firmware_up and now_ns >= self._firmware_ns:
            self._boot()
        while self._mode and self._next_ready_ns <= now_ns:
            self._finish_range(now_ns)

    def _boot(self) -> None:
        self._firmware_up = True
        self._registers.put(FIRMWARE_STATUS, b"\x03")
        if self.faults.model_id is not None:
            self._registers.put(MODEL_ID, self.faults.model_id.to_bytes(2, "big"))
        if self.faults.no_osc_calibration:
            self._registers.put(SLOW_OSC, b"\0\0")

    def _react(self, index: int, value: int) -> None:
        if index == I2C_ADDRESS:
            self.address = value & 0x7F
        elif index == INTERRUPT_CLEAR and value & 1:
            self._set_flag(False)
            self._registers.put(INTERRUPT_STATUS, b"\0")
        elif index == FLAG_POLARITY:
            self._set_flag(False)
        elif index == MODE_START and not self._registers.get(HOLD, 1) & 1:
            self._set_mode(value)

    def _set_mode(self, value: int) -> None:
        self._mode = value & (TIMED | SINGLE | BACK_TO_BACK)
        if not self._mode:
            return
        self._stream = None
        range_ns, self._collection_ns = self._range_time()
        wanted_ns = 0
        if self._mode & TIMED:
            per_ms = max(self._registers.get(SLOW_OSC, 2) & 0x03FF, 1)
            wanted_ms = self._registers.get(INTER_MEASUREMENT, 4) / per_ms
            wanted_ns = round(wanted_ms * 1e6 * self._slowness)
        self._period_ns = max(range_ns, wanted_ns, 1)
        self._next_ready_ns = self._clock.now_ns() + range_ns

    def _range_time(self) -> tuple[int, int]:
        """(whole range, phases A and B) [ns], from the timeout registers."""
        phases_us = 0.0
        for timeout_at, period_at in (
            (TIMEOUT_A, PERIOD_A),
            (TIMEOUT_B, PERIOD_B),
        ):
            timeout = self._registers.get(timeout_at, 2)
            macro_periods = ((timeout & 0xFF) << (timeout >> 8)) + 1
            vcsel_clocks = 2 * (self._registers.get(period_at, 1) + 1)
            phases_us += macro_periods * 2304 * vcsel_clocks * self._pll_period_ns * 1e-3
        phases_us *= self._slowness
        whole_us = phases_us + OVERHEAD_US * self._slowness
        return round(whole_us * 1e3), round(phases_us * 1e3)

    @property
    def _pll_period_ns(self) -> float:
        return 4096e3 / (64.0 * self._registers.get(FAST_OSC, 2))

    def _finish_range(self, now_ns: int) -> None:
        ready_ns = self._next_ready_ns
        self._next_ready_ns += self._period_ns
        error_m = self._noise.next_m()
        self.samples += 1
        self._stream = _after(self._stream)
        seen_by_nobody = self._next_ready_ns <= now_ns and not self._mode & SINGLE
        if self._mode & SINGLE:
            self._mode = 0
        if self.faults.frozen or seen_by_nobody:
            return
        self._publish(self._look(ready_ns), error_m)

    def _look(self, ready_ns: int) -> Seen:
        registers = self._registers
        limits = Limits(
            registers.get(SIGMA_LIMIT, 2) / 4.0,
            registers.get(SIGNAL_LIMIT, 2) / 128.0,
            registers.get(PHASE_LIMIT, 1) / 8.0,
        )
        distance_m = self._distance_m(ready_ns - self._collection_ns, ready_ns)
        return look(self.scene, distance_m, self._collection_ns, self._pll_period_ns, limits)

    def _publish(self, seen: Seen, error_m: float) -> None:
        status = seen.raw_status if self.faults.raw_status is None else self.faults.raw_status
        distance_m = seen.distance_m + error_m * seen.scatter
        self._shown_m = self.faults.shown_m(distance_m, self.samples, self._shown_m)
        distance_mm = round(self._shown_m * 1e3)
        signal = _fixed(seen.signal_mcps, 128.0)
        results = _RESULTS.pack(
            status & 0x1F,
            0,  # report status
            self._stream or 0,
            SPADS << 8,
            signal,
            _fixed(seen.ambient_mcps, 128.0),
            _fixed(seen.sigma_mm, 4.0),
            _fixed(seen.phase_clocks, 2048.0),
            min(max(distance_mm, 0), 0xFFFF),
            signal,
        )
        self._registers.put(RESULTS, results)
        self._registers.put(INTERRUPT_STATUS, b"\x04")
        if not self.faults.silent_flag:
            self._set_flag(True)

    def _set_flag(self, ready: bool) -> None:
        active_low = bool(self._registers.get(FLAG_POLARITY, 1) & 0x10)
        self._registers.put(FLAG, bytes([int(ready != active_low)]))


def _after(stream: int | None) -> int:
    """The stream count runs 0 to 255, then 128 to 255 for ever."""
    if stream is None:
        return 0
    return 128 if stream == 255 else stream + 1


def _fixed(value: float, scale: float) -> int:
    return min(max(round(value * scale), 0), 0xFFFF)
