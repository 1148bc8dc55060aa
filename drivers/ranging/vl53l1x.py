"""One VL53L1X on an I2C bus. Waits are generators that yield when to go on (see foundation.clock).

Every method raises OSError with the kernel's errno when the bus fails after its retries.
"""

from __future__ import annotations

import struct
from typing import NamedTuple

from deltactl.drivers.i2c import TRANSIENT_ERRNOS, I2cBus, Registers
from deltactl.drivers.ranging import registers as reg
from deltactl.drivers.ranging.registers import (
    BUDGET_TIMEOUTS,
    MODE_REGISTERS,
    RESULT_BLOCK,
    STATUS_MASK,
    Mode,
    RangeTiming,
    Register,
    range_timing,
)
from deltactl.foundation.clock import Clock, Task, ns
from deltactl.foundation.errors import SensorFault

_LAYOUT = struct.Struct(">BBBHHHHHHH")
"""0x0089 on: status, report status, stream count, SPADs 8.8, peak signal 9.7 (uncorrected),
ambient 9.7, sigma 14.2, phase 5.11, distance mm, peak signal 9.7 (crosstalk corrected)."""
assert _LAYOUT.size == RESULT_BLOCK.size

MCPS_PER_COUNT = 1.0 / 128.0
"""9.7 fixed point."""
MM_PER_SIGMA_COUNT = 0.25
"""14.2 fixed point."""


class RawSample(NamedTuple):
    """One sample as the chip has it; `signal_mcps` is the crosstalk-corrected rate."""

    raw_status: int
    stream_count: int
    distance_mm: int
    signal_mcps: float
    ambient_mcps: float
    sigma_mm: float
    spads: float


def decode(block: bytes) -> RawSample:
    """Decode 17 bytes read from 0x0089 in one transaction; struct.error on other lengths."""
    status, _, stream, spads, _, ambient, sigma, _, distance_mm, signal = _LAYOUT.unpack(block)
    return RawSample(
        status & STATUS_MASK,
        stream,
        distance_mm,
        signal * MCPS_PER_COUNT,
        ambient * MCPS_PER_COUNT,
        sigma * MM_PER_SIGMA_COUNT,
        spads / 256.0,
    )


FIRST_OF_WRAP = 128


def samples_between(last: int, now: int) -> int:
    """How many samples a stream count has advanced: it runs 0 to 255, then 128 to 255 for ever.

    Advances by 128 or more cannot be distinguished; a count that fell below 128 started anew.
    """
    if now >= last:
        return now - last
    return 256 - last + now - FIRST_OF_WRAP if now >= FIRST_OF_WRAP else now + 1


BOOT_NS = ns(0.0012)
"""VL53L1_FIRMWARE_BOOT_TIME_US; the chip does not acknowledge before."""
BOOT_TIMEOUT_NS = ns(0.5)
RANGE_TIMEOUT_NS = ns(2.0)
POLL_STEP_NS = ns(0.001)


class Vl53l1x:
    """One sensor: boot, address, settings, start and stop, samples."""

    def __init__(self, bus: I2cBus, clock: Clock, retries: int = 3):
        self._bus = bus
        self._clock = clock
        self._retries = retries
        self._chip = self._at(reg.DEFAULT_ADDRESS)
        self._ready_level = 1

    @property
    def address(self) -> int:
        """Its current I2C address."""
        return self._chip.address

    def was_reset(self) -> None:
        """XSHUT was low: the chip is back at 0x29 with nothing set."""
        self._chip = self._at(reg.DEFAULT_ADDRESS)

    def wait_booted(self) -> Task:
        """Wait for the firmware, taking silence as booting. Raises SensorFault after 0.5 s."""
        give_up_ns = self._clock.now_ns() + BOOT_TIMEOUT_NS
        heard = False
        while True:
            try:
                status = self._at(self.address, 0).read(*reg.FIRMWARE_SYSTEM_STATUS)[0]
                heard = True
                if status & reg.BOOTED_BIT:
                    return
            except OSError as error:
                if error.errno not in TRANSIENT_ERRNOS:
                    raise
            if self._clock.now_ns() >= give_up_ns:
                what = "does not finish booting" if heard else "does not answer"
                raise SensorFault(f"{what} at 0x{self.address:02X} 0.5 s after reset")
            yield self._clock.now_ns() + POLL_STEP_NS

    def check_identity(self) -> None:
        """Read the model id. Raises SensorFault when this is no VL53L1X."""
        found = self._read(reg.IDENTIFICATION)
        if found != reg.IDENTITY:
            raise SensorFault(
                f"at 0x{self.address:02X} is no VL53L1X: id 0x{found:04X} instead of"
                f" 0x{reg.IDENTITY:04X}"
            )

    def change_address(self, address: int) -> None:
        """Move to another 7-bit address (until the next reset) and check that it is there."""
        try:
            self._write(reg.I2C_SLAVE_DEVICE_ADDRESS, address)
        except OSError as error:
            # It may have moved although its acknowledgement got lost: the check below tells.
            if error.errno not in TRANSIENT_ERRNOS:
                raise
        self._chip = self._at(address)
        self.check_identity()

    def write_defaults(self, pads_2v8: bool) -> None:
        """Write the ULD's 91 bytes of default settings in one burst."""
        self._chip.write(reg.DEFAULT_BLOCK_START, reg.default_block(pads_2v8))
        polarity = self._read(reg.GPIO_HV_MUX_CTRL)
        self._ready_level = 0 if polarity & reg.ACTIVE_LOW_BIT else 1

    def calibrate_vhv(self) -> Task:
        """Range once and keep the VHV found, as the ULD does; bounded, which ST's loop is not.

        Raises SensorFault when no sample comes within 2 s.
        """
        self.start()
        give_up_ns = self._clock.now_ns() + RANGE_TIMEOUT_NS
        while not self.data_ready():
            if self._clock.now_ns() >= give_up_ns:
                raise SensorFault(f"at 0x{self.address:02X} makes no first sample within 2 s")
            yield self._clock.now_ns() + POLL_STEP_NS
        self.clear_interrupt()
        self.stop()
        self._write(reg.VHV_CONFIG_TIMEOUT_MACROP_LOOP_BOUND, reg.VHV_TWO_BOUNDS)
        self._write(reg.VHV_CONFIG_INIT, reg.VHV_FROM_PREVIOUS_TEMPERATURE)

    def set_mode(self, mode: Mode, budget_ms: int) -> RangeTiming:
        """Distance mode and timing budget (in this order); returns how long a range takes.

        Raises ValueError for a budget that the mode does not have, SensorFault when the chip
        does not know its own oscillator.
        """
        fast_osc = self._read(reg.OSC_MEASURED_FAST_OSC_FREQUENCY)
        if fast_osc == 0:
            raise SensorFault(f"at 0x{self.address:02X} reports a fast oscillator of 0 MHz")
        timing = range_timing(mode, budget_ms, fast_osc)
        for register, value in MODE_REGISTERS[mode].items():
            self._write(register, value)
        phase_a, phase_b = BUDGET_TIMEOUTS[mode][budget_ms]
        self._write(reg.RANGE_CONFIG_TIMEOUT_MACROP_A, phase_a)
        self._write(reg.RANGE_CONFIG_TIMEOUT_MACROP_B, phase_b)
        return timing

    def set_inter_measurement(self, period_ns: int) -> None:
        """Time from the start of one range to the next, by the chip's calibrated oscillator.

        Raises SensorFault when the chip has not calibrated it.
        """
        per_ms = self._read(reg.RESULT_OSC_CALIBRATE_VAL) & reg.OSC_CALIBRATE_MASK
        if per_ms == 0:
            raise SensorFault(f"at 0x{self.address:02X} reports no oscillator calibration")
        self._write(reg.SYSTEM_INTERMEASUREMENT_PERIOD, round(per_ms * period_ns * 1e-6))

    def start(self) -> None:
        """Range again and again; the stream count starts at 0."""
        self.clear_interrupt()
        self._write(reg.SYSTEM_MODE_START, reg.MODE_TIMED)

    def stop(self) -> None:
        """Stop ranging."""
        self._write(reg.SYSTEM_MODE_START, reg.MODE_STOP)

    def data_ready(self) -> bool:
        """Whether the ready flag is at its active level."""
        return self._read(reg.GPIO_TIO_HV_STATUS) & 1 == self._ready_level

    def clear_interrupt(self) -> None:
        """Take the ready flag back after a sample was read."""
        self._write(reg.SYSTEM_INTERRUPT_CLEAR, reg.INTERRUPT_CLEAR_RANGE)

    def read_sample(self) -> RawSample:
        """The latest sample, new or not, in one transaction of 17 bytes."""
        return decode(self._chip.read(*reg.RESULT_BLOCK))

    def _at(self, address: int, retries: int | None = None) -> Registers:
        tries = self._retries if retries is None else retries
        return Registers(self._bus, self._clock, address, tries)

    def _read(self, register: Register) -> int:
        return self._chip.read_int(register.at, register.size)

    def _write(self, register: Register, value: int) -> None:
        self._chip.write_int(register.at, register.size, value)
