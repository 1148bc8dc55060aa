"""The RangingSensors contract, on the simulated sensors (both clocks) and on the robot.

On a Raspberry Pi: `pytest --hardware --robot my-robot.yaml tests/ranging`, with something to see
in front of each sensor within its range.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import pytest

from deltactl.drivers.fakes.ranging_bench import build_rig
from deltactl.drivers.i2c import open_bus
from deltactl.drivers.ranging.bank import AXES, SensorBank
from deltactl.drivers.ranging.contract import Gate, Reading
from deltactl.drivers.ranging.registers import STATUSES
from deltactl.drivers.ranging.robot_sensors import OpenDrainLine
from deltactl.drivers.ranging.slot import XshutLine
from deltactl.drivers.settings import RangingSettings
from deltactl.foundation.clock import Clock, RealClock, VirtualClock, ns, sleep_s


@dataclass
class Backend:
    """Sensors to check, whatever they are made of."""

    bank: SensorBank
    clock: Clock
    lines: tuple[XshutLine, ...]
    settings: RangingSettings

    def collect(self, wanted: int, axes: str = "xyz", limit_s: float = 10.0) -> list[Reading]:
        """Poll at the rate until so many readings have come from each of these axes."""
        readings: list[Reading] = []
        give_up_ns = self.clock.now_ns() + ns(limit_s)
        while min(self.count(readings)[axis] for axis in axes) < wanted:
            assert self.clock.now_ns() < give_up_ns, self.bank.health()
            sleep_s(self.clock, 1.0 / self.settings.rate_hz)
            readings += self.bank.poll()
        return readings

    @staticmethod
    def count(readings: list[Reading]) -> Counter[str]:
        return Counter(reading.axis for reading in readings)


def _simulated(clock: Clock) -> Backend:
    settings = RangingSettings()
    rig = build_rig(settings, clock, lambda axis, start, end: 0.4)
    return Backend(rig.bank, clock, rig.lines, settings)


def _hardware(robot: str) -> Backend:
    from gpiozero import Device

    from deltactl.firmware_py.named_files import find
    from deltactl.firmware_py.robot_file import load_robot

    settings = load_robot(find(robot)).ranging
    clock = RealClock()
    Device.ensure_pin_factory()
    bus = open_bus(settings.bus)
    lines = tuple(OpenDrainLine(Device.pin_factory, pin) for pin in settings.xshut_pins)
    closers = (bus.close, *(line.close for line in lines))
    return Backend(SensorBank(settings, bus, lines, clock, closers), clock, lines, settings)


@pytest.fixture(
    params=["virtual", "realtime", pytest.param("hardware", marks=pytest.mark.hardware)]
)
def backend(request: pytest.FixtureRequest) -> Iterator[Backend]:
    if request.param == "hardware":
        made = _hardware(str(request.config.getoption("--robot")))
    else:
        made = _simulated(VirtualClock() if request.param == "virtual" else RealClock())
    yield made
    made.bank.close()


@pytest.fixture
def started(backend: Backend) -> Backend:
    backend.bank.start()
    return backend


def test_before_the_start_all_are_off_and_after_it_all_are_well(backend: Backend) -> None:
    assert backend.bank.health() == dict.fromkeys(AXES, "off")
    assert backend.bank.poll() == []
    backend.bank.start()
    assert backend.bank.health() == dict.fromkeys(AXES, "ok")


def test_all_three_give_readings_at_their_rate(started: Backend) -> None:
    start_ns = started.clock.now_ns()
    readings = started.collect(wanted=25)
    took_s = (started.clock.now_ns() - start_ns) * 1e-9
    for count in started.count(readings).values():
        assert count <= took_s * started.settings.rate_hz * 1.1 + 2


def test_every_reading_is_new_and_in_order(started: Backend) -> None:
    readings = started.collect(wanted=15)
    for axis in AXES:
        mine = [reading for reading in readings if reading.axis == axis]
        for before, after in pairwise(mine):
            assert after.stream_count > before.stream_count
            assert after.t_ns > before.t_ns


def test_a_time_lies_between_the_polls_around_it(started: Backend) -> None:
    started.collect(wanted=2)
    for _ in range(10):
        before_ns = started.clock.now_ns()
        sleep_s(started.clock, 0.02)
        readings = started.bank.poll()
        now_ns = started.clock.now_ns()
        for reading in readings:
            assert before_ns - ns(0.05) < reading.t_ns < now_ns


def test_a_reading_makes_sense(started: Backend) -> None:
    for reading in started.collect(wanted=5):
        assert 0 <= reading.raw_status <= 31
        if reading.status == 0:
            assert reading.raw_status == 9
            assert 0.0 < reading.distance_m < 5.0
            assert reading.signal_mcps > 0.0
        else:
            assert reading.gate is Gate.STATUS
        assert reading.raw_status in STATUSES


def test_polling_more_often_gives_nothing_twice(started: Backend) -> None:
    start_ns = started.clock.now_ns()
    readings = []
    for _ in range(100):
        readings += started.bank.poll()
        sleep_s(started.clock, 0.002)
    took_s = (started.clock.now_ns() - start_ns) * 1e-9
    for axis in AXES:
        counts = [reading.stream_count for reading in readings if reading.axis == axis]
        assert len(counts) == len(set(counts))
        assert len(counts) <= took_s * started.settings.rate_hz * 1.1 + 2


def test_one_that_was_reset_comes_back_while_the_others_go_on(started: Backend) -> None:
    started.collect(wanted=2)
    started.lines[1].off()
    sleep_s(started.clock, 0.005)
    started.lines[1].on()
    others: list[Reading] = []
    while started.bank.health()["y"] == "ok":
        sleep_s(started.clock, 0.02)
        others += started.bank.poll()
    assert "brown-out" in started.bank.health()["y"]
    while started.bank.health()["y"] != "ok":
        sleep_s(started.clock, 0.02)
        others += started.bank.poll()
    counted = started.count(others)
    assert min(counted["x"], counted["z"]) >= 5
    started.collect(wanted=5)


def test_a_second_start_resets_and_goes_on(started: Backend) -> None:
    before = started.collect(wanted=15)  # so many that a busy machine does not hide the reset
    started.bank.start()
    after = started.collect(wanted=3)
    counted_before, counted_after = ([one.stream_count for one in of] for of in (before, after))
    assert min(counted_after) <= max(counted_before) // 2


def test_after_close_there_is_nothing(started: Backend) -> None:
    started.bank.close()
    assert started.bank.health() == dict.fromkeys(AXES, "off")
    assert started.bank.poll() == []
