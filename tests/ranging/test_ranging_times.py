"""Times of readings, remarks on a slow bus or sensor, and what a poll costs."""

from __future__ import annotations

import re
import time

import pytest

from deltactl.drivers.fakes.ranging_bench import RangingBench
from deltactl.drivers.fakes.vl53l1x_scene import RangeNoise
from deltactl.drivers.ranging.contract import Reading
from deltactl.foundation.clock import ns


def _axes(readings: list[Reading]) -> set[str]:
    return {reading.axis for reading in readings}


def test_times_are_the_middle_of_the_light() -> None:
    """With a target that moves at 0.5 m/s a reading equals the distance at its time."""
    bench = RangingBench()
    for chip in bench.chips.values():
        chip._distance_m = lambda start, end: 0.3 + 0.5e-9 * ((start + end) / 2 - ns(0.2))
    bench.bank.start()
    for reading in bench.run(0.5):
        expected_m = 0.3 + 0.5 * (reading.t_ns * 1e-9 - 0.2)
        assert reading.distance_m == pytest.approx(expected_m, abs=0.0006)


def test_times_hold_for_oscillators_that_are_off() -> None:
    bench = RangingBench(oscillator_errors=(0.012, -0.008, 0.003))
    for chip in bench.chips.values():
        chip._distance_m = lambda start, end: (start + end) / 2 % 1e9 * 1e-9 + 0.1
    bench.bank.start()
    bench.run(30.0)
    errors_s = []
    for reading in bench.run(10.0):
        seen_s = reading.distance_m - 0.1
        error_s = (reading.t_ns * 1e-9 - seen_s + 0.5) % 1.0 - 0.5
        errors_s.append(abs(error_s))
    errors_s.sort()
    assert errors_s[len(errors_s) // 2] < 0.001
    assert errors_s[-1] < 0.005


def test_a_restart_takes_short_steps() -> None:
    """At 400 kHz no poll holds the bus for longer than a few block transfers."""
    bench = RangingBench(wire_hz=400_000)
    bench.bank.start()
    bench.run(0.2)
    bench.chips["y"].brown_out()
    longest_ns = 0
    for _ in range(40):
        bench.clock.sleep_until_ns(bench.clock.now_ns() + ns(0.02))
        before_ns = bench.clock.now_ns()
        bench.bank.poll()
        longest_ns = max(longest_ns, bench.clock.now_ns() - before_ns)
    assert bench.well()
    assert longest_ns < ns(0.006)


@pytest.mark.parametrize(("clock_hz", "advised"), [(400_000, False), (100_000, True)])
def test_a_slow_bus_is_remarked_on_once(clock_hz: int, advised: bool) -> None:
    bench = RangingBench(wire_hz=clock_hz)
    bench.bank.start()
    bench.run(3.0)
    remarks = [event for event in bench.bank.take_events() if "i2c_arm_baudrate" in event]
    assert len(remarks) == int(advised)
    if advised:
        assert "100 kHz" in remarks[0] or "99 kHz" in remarks[0]


def test_a_sensor_slower_than_asked_is_remarked_on() -> None:
    bench = RangingBench(oscillator_errors=(0.0, 0.25, 0.0))
    bench.bank.start()
    bench.run(12.0)
    remarks = [event for event in bench.bank.take_events() if "times a second" in event]
    assert len(remarks) == 1
    assert "sensor y" in remarks[0]
    assert re.search(r"(39|40)\.\d times a second instead of 50", remarks[0])
    assert bench.bank.measured_hz()["y"] == pytest.approx(40.0, rel=0.02)


@pytest.mark.study
@pytest.mark.realtime
def test_a_poll_of_three_costs_well_under_a_millisecond() -> None:
    bench = RangingBench(noise=RangeNoise())
    bench.bank.start()
    took_s = []
    for _ in range(3):
        start_s = time.process_time()
        readings = bench.run(20.0)
        took_s.append((time.process_time() - start_s) / 1000)
        assert len(readings) > 2900
    assert min(took_s) < 0.7e-3
