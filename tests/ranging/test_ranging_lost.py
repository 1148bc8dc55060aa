"""Sensors and buses that do not come back: one clear error, and in time."""

from __future__ import annotations

import pytest

from deltactl.drivers.fakes.ranging_bench import RangingBench
from deltactl.drivers.ranging.contract import Reading
from deltactl.foundation.clock import ns
from deltactl.foundation.errors import BusDead, SensorFault


def _axes(readings: list[Reading]) -> set[str]:
    return {reading.axis for reading in readings}


def test_a_sensor_that_does_not_come_back_is_a_fault_naming_it(bench: RangingBench) -> None:
    bench.run(6.0)
    bench.chips["y"].faults.unpowered = True
    assert _axes(bench.run(1.0)[-4:]) == {"x", "z"}
    with pytest.raises(
        SensorFault, match=r"sensor y \(address 0x31, XSHUT on GPIO 20\): .*0x29.*tried 3 times"
    ):
        bench.run(3.0)
    with pytest.raises(SensorFault, match="sensor y"):
        bench.bank.poll()
    assert "sensor y" in bench.bank.health()["y"]
    bench.chips["y"].faults.clear()
    bench.bank.start()
    assert _axes(bench.run(0.1)) == {"x", "y", "z"}


def test_a_sensor_that_keeps_dying_is_a_fault_in_the_end(bench: RangingBench) -> None:
    for _ in range(2):
        bench.run(1.0)
        bench.chips["y"].brown_out()
    bench.run(1.0)
    assert bench.well()
    bench.chips["y"].brown_out()
    with pytest.raises(SensorFault, match=r"sensor y .*brown-out.*tried 3 times"):
        bench.run(1.0)


@pytest.mark.study
def test_one_that_dies_now_and_then_has_its_attempts_back(bench: RangingBench) -> None:
    for _ in range(8):
        bench.run(6.0)
        bench.chips["y"].brown_out()
        bench.run(0.06)
        bench.run_until(bench.well)


@pytest.mark.parametrize("how", ["stuck", "unpowered", "sda"])
def test_a_dead_bus_is_said_within_a_second(bench: RangingBench, how: str) -> None:
    bench.run(0.5)
    start_ns = bench.clock.now_ns()
    if how == "stuck":
        bench.rig.bus.stuck = True
    for chip in bench.chips.values():
        if how == "unpowered":
            chip.faults.unpowered = True
        if how == "sda":
            chip.faults.sda_stuck = chip.faults.xshut_broken = True
    with pytest.raises(BusDead, match=r"no sensor answers .*check the sensors' supply, SDA"):
        bench.run(5.0)
    assert (bench.clock.now_ns() - start_ns) * 1e-9 < 1.0


def test_a_dead_bus_is_said_at_the_start() -> None:
    bench = RangingBench()
    bench.rig.bus.stuck = True
    with pytest.raises(BusDead, match="no sensor answers"):
        bench.bank.start()
    assert bench.clock.now_ns() < ns(1.0)


def test_a_sensor_that_holds_sda_is_freed_by_its_reset(bench: RangingBench) -> None:
    bench.run(0.1)
    bench.chips["y"].faults.sda_stuck = True
    assert bench.run_until(lambda: not bench.well()) < 0.1
    assert bench.run_until(bench.well, limit_s=3.0) < 1.5


def test_a_bus_that_disappears_is_said_within_a_period(bench: RangingBench) -> None:
    bench.rig.bus.gone = True
    with pytest.raises(BusDead, match=r"adapter fails \(No such device\)"):
        bench.run(0.02)


def test_a_long_pause_between_polls_is_no_fault(bench: RangingBench) -> None:
    bench.run(0.5)
    bench.clock.sleep_until_ns(bench.clock.now_ns() + ns(20.0))
    readings = bench.bank.poll()
    assert _axes(readings) == {"x", "y", "z"}
    assert all(bench.clock.now_ns() - r.t_ns < ns(0.05) for r in readings)
    assert bench.well()
