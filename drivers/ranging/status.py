"""Range status codes of the VL53L1X: what the chip says, and what ST's ULD makes of it.

Sources: `VL53L1_DEVICEERROR_*` of ST's full API, the status table of the ULD
(`VL53L1X_GetRangeStatus`). Codes that neither knows are ULD 255.
"""

from __future__ import annotations

from typing import NamedTuple

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
