"""Every fault knob of the chip model does what it says, and nothing after it is turned back."""

from __future__ import annotations

import pytest

from deltactl.drivers.fakes.ranging_bench import ChipBench
from deltactl.foundation.clock import ns


@pytest.mark.parametrize(
    ("knob", "code"),
    [("nack_transfers", 121), ("timeout_transfers", 110), ("io_error_transfers", 5)],
)
def test_so_many_transfers_fail_with_their_errno(one: ChipBench, knob: str, code: int) -> None:
    one.wait(0.002)
    setattr(one.chip.faults, knob, 3)
    for _ in range(3):
        with pytest.raises(OSError, match=r"\[Errno") as caught:
            one.read(0x010F)
        assert caught.value.errno == code
    assert one.read(0x010F) == b"\xea"


def test_bits_flip_in_what_is_read(one: ChipBench) -> None:
    one.wait(0.002)
    one.chip.faults.flip, one.chip.faults.flip_reads = (1, 0x80), 1
    assert one.read(0x010F, 3) == bytes([0xEA, 0x4C, 0x10])
    assert one.read(0x010F, 3) == bytes([0xEA, 0xCC, 0x10])


def test_frozen_results_repeat(one: ChipBench) -> None:
    one.start()
    one.wait(0.1)
    before = one.read(0x0089, 17)
    one.chip.faults.frozen = True
    one.true_m = 0.9
    one.wait(0.1)
    assert one.read(0x0089, 17) == before
    one.chip.faults.clear()
    one.wait(0.02)
    assert one.distance_mm() == 900


@pytest.mark.parametrize("code", range(32))
def test_every_raw_status_can_be_set(one: ChipBench, code: int) -> None:
    one.chip.faults.raw_status = code
    one.start()
    one.wait(0.02)
    assert one.read(0x0089)[0] == code


def test_a_brown_out_stops_ranging_and_forgets_everything(one: ChipBench) -> None:
    one.start()
    one.wait(0.1)
    one.chip.brown_out()
    assert one.silent()
    one.wait(0.002)
    assert not one.chip.ranging
    assert one.read(0x0030) == b"\x11"


def test_a_stuck_sda_blocks_the_bus_until_that_chip_is_reset(one: ChipBench) -> None:
    one.wait(0.002)
    one.chip.faults.sda_stuck = True
    with pytest.raises(OSError, match="timed out"):
        one.read(0x010F)
    one.chip.set_xshut(False)
    one.chip.set_xshut(True)
    one.wait(0.002)
    assert one.read(0x010F) == b"\xea"


def test_slow_boot_is_silent_then_deaf(one: ChipBench) -> None:
    one.chip.faults.extra_boot_ns, one.chip.faults.deaf_firmware_ns = ns(0.1), ns(0.05)
    one.chip.brown_out()
    one.wait(0.1)
    assert one.silent()
    one.wait(0.002)
    assert one.read(0x00E5) == b"\x02"
    one.wait(0.05)
    assert one.read(0x00E5) == b"\x03"


def test_a_wrong_id_and_a_missing_calibration_can_be_had(one: ChipBench) -> None:
    one.chip.faults.model_id, one.chip.faults.no_osc_calibration = 0xEEAA, True
    one.wait(0.002)
    assert one.read(0x010F, 2) == b"\xee\xaa"
    assert one.read(0x00DE, 2) == b"\0\0"


def test_a_wrapped_target_comes_back_near_and_valid(one: ChipBench) -> None:
    one.true_m = 1.3
    one.chip.scene.wrap_m = 0.64
    one.start()
    one.wait(0.02)
    assert (one.distance_mm(), one.status()) == (20, 9)


def test_a_broken_xshut_wire_leaves_it_running(one: ChipBench) -> None:
    one.wait(0.002)
    one.chip.faults.xshut_broken = True
    one.chip.set_xshut(False)
    assert not one.silent()


def test_without_supply_it_is_not_there(one: ChipBench) -> None:
    one.wait(0.002)
    one.chip.faults.unpowered = True
    assert one.silent()


def test_a_lost_flag_stays_low_while_samples_go_on(one: ChipBench) -> None:
    one.chip.faults.silent_flag = True
    one.start()
    one.wait(0.1)
    assert one.flag() == 0
    assert one.stream() == 4
