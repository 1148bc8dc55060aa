"""Facts of the VL53L1X as data: registers, default settings, modes, timing budgets, status codes.

Sources: ST's register map and core API (`vl53l1_register_map.h`), ST's Ultra Lite Driver
(ULD) as in stm32duino/VL53L1X, `VL53L1_DEVICEERROR_*` of ST's full API, and Pololu's and
Adafruit's drivers; they were read for facts, no code was taken. Indices are 16 bits, numbers
big-endian. A timeout register holds (msb << 8) | lsb and means (lsb << msb) + 1 macro periods.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

DEFAULT_ADDRESS = 0x29
"""7-bit address after power-up, an XSHUT pulse, or a soft reset."""


class Register(NamedTuple):
    """Index and size [bytes] of a register."""

    at: int
    size: int


I2C_SLAVE_DEVICE_ADDRESS = Register(0x0001, 1)
"""[6:0] new 7-bit address, valid from the next transaction, lost at reset."""
OSC_MEASURED_FAST_OSC_FREQUENCY = Register(0x0006, 2)
"""MHz, 4.12 fixed point, from the part's NVM."""
VHV_CONFIG_TIMEOUT_MACROP_LOOP_BOUND = Register(0x0008, 1)
VHV_CONFIG_INIT = Register(0x000B, 1)
PAD_I2C_HV_EXTSUP_CONFIG = Register(0x002E, 1)
"""bit 0: I2C pads pulled up to AVDD ("2V8 mode") instead of 1.8 V."""
GPIO_HV_MUX_CTRL = Register(0x0030, 1)
"""bit 4: 0 = the ready flag is active high, 1 = active low. Reset 0x11."""
GPIO_TIO_HV_STATUS = Register(0x0031, 1)
"""bit 0: level of the ready flag."""
PHASECAL_CONFIG_TIMEOUT_MACROP = Register(0x004B, 1)
RANGE_CONFIG_TIMEOUT_MACROP_A = Register(0x005E, 2)
RANGE_CONFIG_VCSEL_PERIOD_A = Register(0x0060, 1)
RANGE_CONFIG_TIMEOUT_MACROP_B = Register(0x0061, 2)
RANGE_CONFIG_VCSEL_PERIOD_B = Register(0x0063, 1)
RANGE_CONFIG_SIGMA_THRESH = Register(0x0064, 2)
"""mm, 14.2 fixed point."""
RANGE_CONFIG_MIN_COUNT_RATE_RTN_LIMIT = Register(0x0066, 2)
"""MCPS, 9.7 fixed point."""
RANGE_CONFIG_VALID_PHASE_HIGH = Register(0x0069, 1)
SYSTEM_INTERMEASUREMENT_PERIOD = Register(0x006C, 4)
"""In periods of the slow oscillator: OSC_CALIBRATE_VAL * ms."""
SD_CONFIG_WOI_SD0 = Register(0x0078, 2)
SD_CONFIG_INITIAL_PHASE_SD0 = Register(0x007A, 2)
SYSTEM_INTERRUPT_CLEAR = Register(0x0086, 1)
SYSTEM_MODE_START = Register(0x0087, 1)
RESULT_BLOCK = Register(0x0089, 17)
"""Status to signal rate: one transaction, or status and distance may be of different samples."""
RESULT_OSC_CALIBRATE_VAL = Register(0x00DE, 2)
"""& 0x03FF."""
FIRMWARE_SYSTEM_STATUS = Register(0x00E5, 1)
"""bit 0: booted."""
IDENTIFICATION = Register(0x010F, 2)
"""Model id 0xEA, module type 0xCC."""

IDENTITY = 0xEACC
BOOTED_BIT = 0x01
OSC_CALIBRATE_MASK = 0x03FF
ACTIVE_LOW_BIT = 0x10
PADS_2V8_BIT = 0x01

MODE_TIMED = 0x40
"""SYSTEM_MODE_START: range again and again, one inter-measurement period apart."""
MODE_STOP = 0x00
INTERRUPT_CLEAR_RANGE = 0x01

VHV_TWO_BOUNDS = 0x09
VHV_FROM_PREVIOUS_TEMPERATURE = 0x00

DEFAULT_BLOCK_START = 0x002D
DEFAULT_BLOCK = bytes.fromhex(
    "00 00 00 01 02 00 02 08 00 08 10 01 01 00 00 00"  # 2D
    "00 FF 00 0F 00 00 00 00 00 20 0B 00 00 02 0A 21"  # 3D
    "00 00 05 00 00 00 00 C8 00 00 38 FF 01 00 08 00"  # 4D
    "00 01 CC 0F 01 F1 0D 01 68 00 80 08 B8 00 00 00"  # 5D
    "00 0F 89 00 00 00 00 00 00 00 01 0F 0D 0E 0E 00"  # 6D
    "00 02 C7 FF 9B 00 00 00 01 00 00"  # 7D
)
"""0x2D to 0x87 as in the ULD: long mode, 100 ms, active-high flag, ROI 16x16, not ranging."""


def default_block(pads_2v8: bool) -> bytes:
    """The default settings; `pads_2v8` for boards whose I2C is pulled up to 2.8 V or more."""
    block = bytearray(DEFAULT_BLOCK)
    if pads_2v8:
        block[PAD_I2C_HV_EXTSUP_CONFIG.at - DEFAULT_BLOCK_START] |= PADS_2V8_BIT
    return bytes(block)


Mode = Literal["short", "long"]

_OF_MODE = (
    *(PHASECAL_CONFIG_TIMEOUT_MACROP, RANGE_CONFIG_VCSEL_PERIOD_A, RANGE_CONFIG_VCSEL_PERIOD_B),
    *(RANGE_CONFIG_VALID_PHASE_HIGH, SD_CONFIG_WOI_SD0, SD_CONFIG_INITIAL_PHASE_SD0),
)
MODE_REGISTERS: dict[Mode, dict[Register, int]] = {
    "short": dict(zip(_OF_MODE, (0x14, 0x07, 0x05, 0x38, 0x0705, 0x0606), strict=True)),
    "long": dict(zip(_OF_MODE, (0x0A, 0x0F, 0x0D, 0xB8, 0x0F0D, 0x0E0E), strict=True)),
}
"""What the ULD writes for each mode. After a change of mode the budget is written again."""

BUDGET_TIMEOUTS: dict[Mode, dict[int, tuple[int, int]]] = {
    "short": {
        15: (0x001D, 0x0027),
        20: (0x0051, 0x006E),
        33: (0x00D6, 0x006E),  # B repeats that of 20 ms in every copy: ST's oversight, kept
        50: (0x01AE, 0x01E8),
        100: (0x02E1, 0x0388),
        200: (0x03E1, 0x0496),
        500: (0x0591, 0x05C1),
    },
    "long": {
        20: (0x001E, 0x0022),
        33: (0x0060, 0x006E),
        50: (0x00AD, 0x00C6),
        100: (0x01CC, 0x01EA),
        200: (0x02D9, 0x02F8),
        500: (0x048F, 0x04A4),
    },
}
"""Budget [ms] -> timeout registers of the phases A and B."""

OVERHEAD_US = 4528.0
"""Time of a range that is not phase A or B (full API, low-power auto mode)."""
PLL_CLOCKS_PER_MACRO_PERIOD = 2304
PLL_MULTIPLIER = 64
FAST_OSC_FRACTION = 4096
"""OSC_MEASURED__FAST_OSC__FREQUENCY is in MHz / 4096."""


def decode_timeout(register: int) -> int:
    """A timeout register as macro periods."""
    return ((register & 0xFF) << (register >> 8)) + 1


def macro_period_us(fast_osc: int, vcsel_period: int) -> float:
    """Length of a macro period [us], from registers 0x0006 and 0x0060 or 0x0063."""
    pll_period_us = FAST_OSC_FRACTION / (PLL_MULTIPLIER * fast_osc)
    return PLL_CLOCKS_PER_MACRO_PERIOD * 2 * (vcsel_period + 1) * pll_period_us


class RangeTiming(NamedTuple):
    """How long one range takes [ns], and the part of it, at its end, that measures distance."""

    range_ns: int
    collection_ns: int


def range_timing(mode: Mode, budget_ms: int, fast_osc: int) -> RangeTiming:
    """Timing of a range with a budget of the ULD's table. Raises ValueError when not in it."""
    timeouts = BUDGET_TIMEOUTS[mode].get(budget_ms)
    if timeouts is None:
        allowed = ", ".join(str(ms) for ms in BUDGET_TIMEOUTS[mode])
        raise ValueError(f"no timing budget of {budget_ms} ms in {mode} mode; there are {allowed}")
    written = MODE_REGISTERS[mode]
    periods = written[RANGE_CONFIG_VCSEL_PERIOD_A], written[RANGE_CONFIG_VCSEL_PERIOD_B]
    phases_us = sum(
        decode_timeout(timeout) * macro_period_us(fast_osc, period)
        for timeout, period in zip(timeouts, periods, strict=True)
    )
    return RangeTiming(round((phases_us + OVERHEAD_US) * 1e3), round(phases_us * 1e3))


STATUS_MASK = 0x1F
"""The upper bits of the byte are threshold flags and a group id."""

RANGE_VALID = 0
NO_WRAP_CHECK = 6
UNKNOWN = 255


class RangeStatus(NamedTuple):
    """One code: ST's name, the ULD's number, what it means, and whether the part itself fails."""

    name: str
    uld: int
    says: str
    hardware_fault: bool = False


STATUSES: dict[int, RangeStatus] = {
    1: RangeStatus("VCSEL_CONTINUITY", UNKNOWN, "laser fault (continuity)", True),
    2: RangeStatus("VCSEL_WATCHDOG", UNKNOWN, "laser fault (watchdog)", True),
    3: RangeStatus("NO_VHV_VALUE_FOUND", 5, "hardware fault (no VHV value)", True),
    4: RangeStatus("MSRC_NO_TARGET", 2, "no target, or too weak a signal"),
    5: RangeStatus("RANGE_PHASE_CHECK", 4, "out of bounds (phase)"),
    6: RangeStatus("SIGMA_THRESHOLD_CHECK", 1, "too noisy (sigma)"),
    7: RangeStatus("PHASE_CONSISTENCY", 7, "wrapped target"),
    8: RangeStatus("MIN_CLIP", 3, "closer than the minimum"),
    9: RangeStatus("RANGE_COMPLETE", RANGE_VALID, "valid"),
    12: RangeStatus("RANGE_IGNORE_THRESHOLD", 9, "crosstalk stronger than the signal"),
    13: RangeStatus("USER_ROI_CLIP", 13, "region of interest clipped"),
    17: RangeStatus("MULT_CLIP", UNKNOWN, "hardware fault (multiple clip)", True),
    18: RangeStatus("GPH_STREAM_COUNT_0_READY", 10, "synchronisation, not a sample"),
    19: RangeStatus("RANGE_COMPLETE_NO_WRAP_CHECK", NO_WRAP_CHECK, "valid, not yet wrap-checked"),
    22: RangeStatus("RANGE_COMPLETE_MERGED_PULSE", 11, "several targets merged"),
    23: RangeStatus("PREV_RANGE_NO_TARGETS", 12, "lack of signal"),
}

_OTHER = RangeStatus("UNKNOWN", UNKNOWN, "unknown status")


def explain(raw_status: int) -> RangeStatus:
    """What a raw status (masked or not) means."""
    return STATUSES.get(raw_status & STATUS_MASK, _OTHER)


def uld_status(raw_status: int, stream_count: int) -> int:
    """The ULD's number; the first sample after a start has no wrap check yet (Pololu)."""
    uld = explain(raw_status).uld
    return NO_WRAP_CHECK if uld == RANGE_VALID and stream_count == 0 else uld
