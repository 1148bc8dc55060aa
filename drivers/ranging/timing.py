"""Distance modes, timing budgets and timeouts of the VL53L1X.

Modes and budgets are the ULD's tables; the formulas are those of ST's full API and Pololu's
driver. A timeout register holds (msb << 8) | lsb and means (lsb << msb) + 1 macro periods.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

from deltactl.drivers.ranging.registers import (
    PHASECAL_CONFIG_TIMEOUT_MACROP,
    RANGE_CONFIG_VALID_PHASE_HIGH,
    RANGE_CONFIG_VCSEL_PERIOD_A,
    RANGE_CONFIG_VCSEL_PERIOD_B,
    SD_CONFIG_INITIAL_PHASE_SD0,
    SD_CONFIG_WOI_SD0,
    Register,
)

Mode = Literal["short", "long"]

MODE_REGISTERS: dict[Mode, tuple[tuple[Register, int], ...]] = {
    "short": (
        (PHASECAL_CONFIG_TIMEOUT_MACROP, 0x14),
        (RANGE_CONFIG_VCSEL_PERIOD_A, 0x07),
        (RANGE_CONFIG_VCSEL_PERIOD_B, 0x05),
        (RANGE_CONFIG_VALID_PHASE_HIGH, 0x38),
        (SD_CONFIG_WOI_SD0, 0x0705),
        (SD_CONFIG_INITIAL_PHASE_SD0, 0x0606),
    ),
    "long": (
        (PHASECAL_CONFIG_TIMEOUT_MACROP, 0x0A),
        (RANGE_CONFIG_VCSEL_PERIOD_A, 0x0F),
        (RANGE_CONFIG_VCSEL_PERIOD_B, 0x0D),
        (RANGE_CONFIG_VALID_PHASE_HIGH, 0xB8),
        (SD_CONFIG_WOI_SD0, 0x0F0D),
        (SD_CONFIG_INITIAL_PHASE_SD0, 0x0E0E),
    ),
}
"""What the ULD writes for each mode. After a change of mode the budget is written again."""

VCSEL_PERIODS: dict[Mode, tuple[int, int]] = {"short": (0x07, 0x05), "long": (0x0F, 0x0D)}

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


def encode_timeout(mclks: int) -> int:
    """Macro periods as a timeout register, rounded down to what it can hold.

    Raises ValueError below 1 macro period.
    """
    if mclks < 1:
        raise ValueError(f"a timeout is at least 1 macro period (got {mclks})")
    lsb, msb = mclks - 1, 0
    while lsb > 0xFF:
        lsb >>= 1
        msb += 1
    return (msb << 8) | lsb


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
    phases_us = sum(
        decode_timeout(timeout) * macro_period_us(fast_osc, period)
        for timeout, period in zip(timeouts, VCSEL_PERIODS[mode], strict=True)
    )
    return RangeTiming(round((phases_us + OVERHEAD_US) * 1e3), round(phases_us * 1e3))
