"""Encodings and tables of the VL53L1X against the facts sheet and against each other."""

from __future__ import annotations

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from deltactl.drivers.ranging import registers as reg
from deltactl.drivers.ranging.registers import (
    BUDGET_TIMEOUTS,
    MODE_REGISTERS,
    STATUSES,
    decode_timeout,
    explain,
    macro_period_us,
    range_timing,
    uld_status,
)
from deltactl.drivers.ranging.vl53l1x import decode, samples_between

FAST_OSC = 0xBCCC


@given(st.integers(0, 0xFF), st.integers(0, 0x12))
def test_timeout_decodes_as_the_sheet_says(lsb: int, msb: int) -> None:
    assert decode_timeout((msb << 8) | lsb) == lsb * 2**msb + 1


def test_macro_periods_are_those_of_the_sheet() -> None:
    assert macro_period_us(FAST_OSC, 0x07) == pytest.approx(49, abs=0.5)
    assert macro_period_us(FAST_OSC, 0x0F) == pytest.approx(98, abs=0.5)


@pytest.mark.parametrize("mode", ["short", "long"])
def test_every_budget_fits_its_name_and_grows(mode: str) -> None:
    budgets = BUDGET_TIMEOUTS[mode]  # type: ignore[index]
    lengths_ms = [range_timing(mode, ms, FAST_OSC).range_ns / 1e6 for ms in budgets]  # type: ignore[arg-type]
    assert lengths_ms == sorted(lengths_ms)
    for ms, length_ms in zip(budgets, lengths_ms, strict=True):
        assert 0.4 * ms < length_ms <= ms


def test_the_two_phases_of_a_budget_are_equally_long_but_for_the_oversight_of_st() -> None:
    odd = []
    for mode, budgets in BUDGET_TIMEOUTS.items():
        written = MODE_REGISTERS[mode]
        periods = (
            written[reg.RANGE_CONFIG_VCSEL_PERIOD_A],
            written[reg.RANGE_CONFIG_VCSEL_PERIOD_B],
        )
        for ms, timeouts in budgets.items():
            a_us, b_us = (
                decode_timeout(timeout) * macro_period_us(FAST_OSC, period)
                for timeout, period in zip(timeouts, periods, strict=True)
            )
            if abs(a_us / b_us - 1.0) > 0.15:
                odd.append((mode, ms))
    assert odd == [("short", 33)]


def test_a_budget_that_a_mode_lacks_is_refused_with_those_it_has() -> None:
    with pytest.raises(ValueError, match=r"no timing budget of 15 ms in long mode.*20, 33, 50"):
        range_timing("long", 15, FAST_OSC)


def _in_block(block: bytes, register: reg.Register) -> int:
    start = register.at - reg.DEFAULT_BLOCK_START
    return int.from_bytes(block[start : start + register.size], "big")


def test_the_default_block_means_what_the_sheet_says_of_it() -> None:
    block = reg.default_block(pads_2v8=False)
    assert len(block) == 0x87 - 0x2D + 1
    assert _in_block(block, reg.GPIO_HV_MUX_CTRL) == 0x01  # active high
    assert _in_block(block, reg.RANGE_CONFIG_SIGMA_THRESH) / 4 == 90.0
    assert _in_block(block, reg.RANGE_CONFIG_MIN_COUNT_RATE_RTN_LIMIT) / 128 == 1.0
    assert _in_block(block, reg.SYSTEM_MODE_START) == reg.MODE_STOP
    assert _in_block(block, reg.SYSTEM_INTERMEASUREMENT_PERIOD) == 0x0F89
    for register, value in MODE_REGISTERS["long"].items():
        assert _in_block(block, register) == value


def test_the_pad_bit_is_all_that_the_supply_changes() -> None:
    low, high = reg.default_block(pads_2v8=False), reg.default_block(pads_2v8=True)
    changed = [i + reg.DEFAULT_BLOCK_START for i in range(len(low)) if low[i] != high[i]]
    assert changed == [0x2E]
    assert high[1] == 0x01


@pytest.mark.parametrize(
    ("raw", "uld"),
    [(9, 0), (6, 1), (4, 2), (8, 3), (5, 4), (3, 5), (19, 6), (7, 7), (12, 9), (18, 10)]
    + [(22, 11), (23, 12), (13, 13)]
    + [(raw, 255) for raw in (0, 1, 2, 10, 11, 14, 15, 16, 17, 20, 21, 24, 31)],
)
def test_status_codes_map_as_in_the_uld(raw: int, uld: int) -> None:
    assert uld_status(raw, stream_count=5) == uld
    assert uld_status(raw | 0xE0, stream_count=5) == uld  # threshold flags and group id


def test_the_first_sample_is_not_yet_wrap_checked() -> None:
    assert uld_status(9, stream_count=0) == 6
    assert uld_status(6, stream_count=0) == 1


def test_hardware_faults_are_those_of_the_sheet() -> None:
    assert {raw for raw, status in STATUSES.items() if status.hardware_fault} == {1, 2, 3, 17}
    assert explain(31).says == "unknown status"


@given(
    status=st.integers(0, 255),
    stream=st.integers(0, 255),
    rest=st.tuples(*[st.integers(0, 0xFFFF)] * 7),
)
def test_the_seventeen_bytes_decode_to_their_fields(
    status: int, stream: int, rest: tuple[int, ...]
) -> None:
    spads, _, ambient, sigma, _, distance, signal = rest
    block = bytes([status, 0, stream]) + struct.pack(">7H", *rest)
    sample = decode(block)
    assert sample.raw_status == status & 0x1F
    assert sample.stream_count == stream
    assert sample.distance_mm == distance
    assert sample.signal_mcps * 128 == signal
    assert sample.ambient_mcps * 128 == ambient
    assert sample.sigma_mm * 4 == sigma
    assert sample.spads * 256 == spads


def test_a_short_read_is_not_decoded() -> None:
    with pytest.raises(struct.error):
        decode(bytes(16))


@given(st.integers(0, 1000), st.integers(0, 127))
def test_stream_counts_are_counted_across_their_wrap(first: int, advance: int) -> None:
    def count(sample: int) -> int:
        return sample if sample < 256 else 128 + (sample - 256) % 128

    assert samples_between(count(first), count(first + advance)) == advance


def test_a_count_that_started_anew_counts_from_its_zero() -> None:
    assert samples_between(200, 3) == 4
