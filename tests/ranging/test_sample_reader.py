"""The reader of one sensor, over one that is told what to say: when it asks again, and clears."""

from __future__ import annotations

import errno
from typing import Any

import pytest
from smbus2 import i2c_msg

from deltactl.drivers.ranging.bank import SILENCE_TRANSFERS, BusWatch
from deltactl.drivers.ranging.sample_reader import SampleReader
from deltactl.drivers.ranging.vl53l1x import RawSample
from deltactl.drivers.settings import RangingSettings
from deltactl.foundation.clock import VirtualClock, ns
from deltactl.foundation.errors import BusDead

PERIOD_NS = ns(0.02)


class Told:
    """A sensor with the stream count that it was told; counts what it is asked for."""

    address = 0x30

    def __init__(self) -> None:
        self.count = self.read = self.cleared = 0

    def read_sample(self) -> RawSample:
        self.read += 1
        return RawSample(9, self.count, 300, 20.0, 0.1, 2.0, 128.0)

    def clear_interrupt(self) -> None:
        self.cleared += 1


class Asked:
    """A reader of it, on a clock that is set by hand."""

    def __init__(self) -> None:
        self.clock, self.sensor = VirtualClock(), Told()
        sensor: Any = self.sensor
        self.reader = SampleReader("x", 0.0, sensor, self.clock, RangingSettings(rate_hz=50.0))
        self.reader.started()

    def at(self, periods: float, count: int) -> int:
        """How often the sensor is read when it is asked then."""
        self.clock.sleep_until_ns(round(periods * PERIOD_NS))
        self.sensor.count, before = count, self.sensor.read
        self.reader.read()
        return self.sensor.read - before


def test_a_count_that_fits_the_time_is_read_once() -> None:
    asked = Asked()
    assert [asked.at(1.5, 1), asked.at(2.5, 2), asked.at(4.5, 4)] == [1, 1, 1]


def test_a_sensor_is_not_asked_before_it_can_have_a_sample() -> None:
    asked = Asked()
    assert asked.at(0.5, 0) == 0, "a first sample takes a period, or a tenth less"
    assert [asked.at(0.95, 0), asked.at(1.5, 1)] == [1, 1]
    assert asked.at(1.7, 1) == 0, "0.95 + 0.9 periods is the earliest"
    assert asked.at(2.5, 2) == 1


def test_a_silent_sensor_is_asked_at_every_poll() -> None:
    asked = Asked()
    asked.at(1.5, 1)
    assert [asked.at(2.5 + 0.1 * poll, 1) for poll in range(5)] == [1] * 5


def test_only_a_new_count_can_fail_to_fit_the_time() -> None:
    """Nothing new for long is a sensor that is late: asking it twice would not help."""
    asked = Asked()
    asked.at(1.5, 1)
    assert asked.at(9.5, 1) == 1
    assert asked.at(9.6, 2) == 2  # one more after eight periods: was a bit flipped?


def test_an_overdue_sample_is_cleared_for_after_two_periods_and_a_margin() -> None:
    asked = Asked()
    asked.at(1.5, 1)
    taken = asked.sensor.cleared
    asked.at(1.5 + 2.9, 1)
    assert asked.sensor.cleared == taken
    asked.at(1.5 + 3.1, 1)
    assert asked.sensor.cleared == taken + 1


class Silent:
    """A bus on which nobody acknowledges."""

    def i2c_rdwr(self, *i2c_msgs: i2c_msg) -> None:
        raise OSError(errno.EREMOTEIO, "Remote I/O error")

    def close(self) -> None:
        pass


@pytest.mark.parametrize(("transfers", "dead"), [(SILENCE_TRANSFERS - 1, False),
                                                 (SILENCE_TRANSFERS, True)])  # fmt: skip
def test_so_many_transfers_without_an_answer_are_a_dead_bus(transfers: int, dead: bool) -> None:
    clock = VirtualClock()
    watch = BusWatch(Silent(), clock)
    for _ in range(transfers):
        with pytest.raises(OSError, match="Remote"):
            watch.i2c_rdwr(i2c_msg.write(0x30, b"\0"))
    clock.sleep_until_ns(ns(0.7))
    if dead:
        with pytest.raises(BusDead, match=r"no sensor answers on the I2C bus for 0\.7 s"):
            watch.check_alive(starting=False)
    else:
        watch.check_alive(starting=False)
