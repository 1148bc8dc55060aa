"""Starting three sensors: what may be found on the bus, and what is missing there."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import pytest
from smbus2 import i2c_msg

from deltactl.drivers.fakes.ranging_bench import RangingBench
from deltactl.drivers.ranging.contract import Reading
from deltactl.foundation.clock import ns
from deltactl.foundation.errors import SensorFault


def _axes(readings: list[Reading]) -> set[str]:
    return {reading.axis for reading in readings}


def test_a_daemon_restart_finds_the_sensors_at_their_old_addresses(bench: RangingBench) -> None:
    assert [chip.address for chip in bench.chips.values()] == [0x30, 0x31, 0x32]
    bench.bank.start()
    assert bench.well()
    assert [chip.address for chip in bench.chips.values()] == [0x30, 0x31, 0x32]


def test_nobody_is_left_at_0x29(bench: RangingBench) -> None:
    assert not any(chip.answers(0x29) for chip in bench.chips.values())


def test_starts_are_staggered_over_the_period() -> None:
    windows: dict[str, list[int]] = {"x": [], "y": [], "z": []}
    bench = RangingBench()

    def watch(axis: str) -> Callable[[int, int], float]:
        return lambda start, end: windows[axis].append(end) or 0.5  # type: ignore[func-returns-value]

    for axis, chip in bench.chips.items():
        chip._distance_m = watch(axis)
    bench.bank.start()
    bench.run(0.1)
    x, y, z = (windows[axis][-1] for axis in "xyz")
    third = ns(0.02) / 3
    assert (y - x) % ns(0.02) == pytest.approx(third, abs=1000)
    assert (z - x) % ns(0.02) == pytest.approx(2 * third, abs=1000)


def test_a_missing_sensor_is_named_with_axis_address_and_pin() -> None:
    bench = RangingBench()
    bench.chips["z"].faults.unpowered = True
    with pytest.raises(
        SensorFault,
        match=r"sensor z \(address 0x32, XSHUT on GPIO 21\): does not answer .* tried 3 times",
    ):
        bench.bank.start()
    assert bench.clock.now_ns() < ns(3.0)
    assert bench.bank.health() == dict.fromkeys("xyz", "off")


@pytest.mark.parametrize("missing", ["xy", "xz", "yz"])
def test_of_two_missing_sensors_the_first_to_give_up_is_named(missing: str) -> None:
    bench = RangingBench()
    for axis in missing:
        bench.chips[axis].faults.unpowered = True
    with pytest.raises(SensorFault, match=rf"sensor [{missing}] .*does not answer"):
        bench.bank.start()


def test_a_wrong_chip_is_named() -> None:
    bench = RangingBench()
    bench.chips["x"].faults.model_id = 0xEEAA
    with pytest.raises(SensorFault, match=r"sensor x .*no VL53L1X: id 0xEEAA"):
        bench.bank.start()


@pytest.mark.parametrize("restarted", [False, True], ids=["at 0x29", "at its old address"])
def test_a_broken_xshut_wire_is_found_before_addresses_collide(restarted: bool) -> None:
    bench = RangingBench()
    if restarted:
        bench.bank.start()
    else:
        bench.clock.sleep_until_ns(ns(0.01))
    bench.chips["y"].faults.xshut_broken = True
    where = "0x31" if restarted else "0x29"
    with pytest.raises(SensorFault, match=rf"somebody answers at {where} .*GPIO 4, 20, 21"):
        bench.bank.start()


def test_a_slow_boot_is_waited_for() -> None:
    bench = RangingBench()
    for chip in bench.chips.values():
        chip.faults.extra_boot_ns = ns(0.3)
    bench.bank.start()
    assert bench.well()


def test_a_start_through_a_noisy_bus_succeeds() -> None:
    bench = RangingBench()
    real, count = bench.rig.bus.i2c_rdwr, 0

    def noisy(*messages: object) -> None:
        nonlocal count
        count += 1
        if count % 5 == 0:
            raise OSError(5, "Input/output error")
        real(*messages)  # type: ignore[arg-type]

    bench.rig.bus.i2c_rdwr = noisy
    bench.bank.start()
    assert _axes(bench.run(0.1)) == {"x", "y", "z"}


@pytest.mark.parametrize("slow_s", [0.0, 0.02])
def test_never_do_two_sensors_answer_at_0x29(slow_s: float) -> None:
    """Out of reset one at a time: of two, both would take the new address that is meant for one.

    Slow ones are silent for long, so that the next would find nobody there, or stay there for long.
    """
    bench = RangingBench()
    for chip in bench.chips.values():
        chip.faults.extra_boot_ns = ns(slow_s)
        chip.faults.deaf_firmware_ns = ns(2.0 * slow_s)
    at_once: list[int] = []
    carry_out = bench.rig.bus._transfer

    def watched(messages: Sequence[i2c_msg]) -> tuple[int | None, int]:
        at_once.append(sum(chip.answers(0x29) for chip in bench.chips.values()))
        return carry_out(messages)

    bench.rig.bus._transfer = watched  # type: ignore[method-assign]
    bench.bank.start()
    assert max(at_once) == 1
