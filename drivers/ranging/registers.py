"""Registers of the VL53L1X and its default settings, as data.

Sources: ST's register map and core API (`vl53l1_register_map.h`), ST's Ultra Lite Driver
(ULD) as in stm32duino/VL53L1X, and Pololu's and Adafruit's drivers; they were read for facts,
no code was taken. Indices are 16 bits, numbers big-endian.
"""

from __future__ import annotations

from typing import NamedTuple

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
SYSTEM_GROUPED_PARAMETER_HOLD = Register(0x0082, 1)
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
