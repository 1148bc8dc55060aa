"""The 17 result bytes of a VL53L1X as numbers."""

from __future__ import annotations

import struct
from typing import NamedTuple

from deltactl.drivers.ranging.registers import RESULT_BLOCK
from deltactl.drivers.ranging.status import STATUS_MASK

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

    Advances by 128 or more cannot be told apart; a count that fell below 128 started anew.
    """
    if now >= last:
        return now - last
    return 256 - last + now - FIRST_OF_WRAP if now >= FIRST_OF_WRAP else now + 1
