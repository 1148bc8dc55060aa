"""The fake bus against what the kernel does, and the register access over it."""

from __future__ import annotations

import errno

import pytest
from gpiozero import DigitalOutputDevice
from gpiozero.pins.mock import MockFactory
from smbus2 import i2c_msg

from deltactl.drivers.fakes.i2c_bus import FakeI2cBus
from deltactl.drivers.fakes.mock_pins import connect_xshut
from deltactl.drivers.fakes.vl53l1x_chip import Vl53l1xChip
from deltactl.drivers.i2c import Registers, open_bus
from deltactl.drivers.ranging.robot_sensors import OpenDrainLine
from deltactl.foundation.clock import VirtualClock, ns
from deltactl.foundation.errors import BusDead


def _chip(clock: VirtualClock) -> Vl53l1xChip:
    return Vl53l1xChip(clock, lambda start, end: 0.5)


@pytest.fixture
def clock() -> VirtualClock:
    return VirtualClock()


def _boot(clock: VirtualClock) -> None:
    clock.sleep_until_ns(clock.now_ns() + ns(0.002))


def test_nobody_at_an_address_is_errno_121(clock: VirtualClock) -> None:
    bus = FakeI2cBus(clock, [])
    with pytest.raises(OSError, match="Remote I/O") as caught:
        bus.i2c_rdwr(i2c_msg.read(0x40, 1))
    assert caught.value.errno == errno.EREMOTEIO


def test_two_chips_at_one_address_both_listen_and_their_bytes_are_anded(
    clock: VirtualClock,
) -> None:
    chips = [_chip(clock), _chip(clock)]
    chips[0].faults.model_id, chips[1].faults.model_id = 0xF0F0, 0xCCCC
    bus = FakeI2cBus(clock, chips)
    _boot(clock)
    both = Registers(bus, clock, 0x29, 0)
    assert both.read_int(0x010F, 2) == 0xC0C0
    both.write_int(0x0072, 2, 0x1234)
    chips[0].set_xshut(False)
    assert both.read_int(0x0072, 2) == 0x1234


def test_one_undisturbed_chip_is_enough_to_be_acknowledged(clock: VirtualClock) -> None:
    chips = [_chip(clock), _chip(clock)]
    bus = FakeI2cBus(clock, chips)
    _boot(clock)
    chips[0].faults.nack_transfers = 1
    assert Registers(bus, clock, 0x29, 0).read_int(0x010F, 2) == 0xEACC


def test_a_closed_a_lost_and_a_stuck_bus_have_their_errno(clock: VirtualClock) -> None:
    bus = FakeI2cBus(clock, [_chip(clock)])
    _boot(clock)
    chip = Registers(bus, clock, 0x29, 0)
    codes = []
    for knob in ("stuck", "gone"):
        setattr(bus, knob, True)
        with pytest.raises(OSError, match="Errno") as caught:
            chip.read(0x010F, 1)
        codes.append(caught.value.errno)
        setattr(bus, knob, False)
    with bus:
        chip.read(0x010F, 1)
    with pytest.raises(OSError, match="Errno") as caught:
        chip.read(0x010F, 1)
    assert [*codes, caught.value.errno] == [errno.ETIMEDOUT, errno.ENODEV, errno.EBADF]


@pytest.mark.parametrize(("clock_hz", "read_s"), [(400_000, 0.00048), (100_000, 0.0019)])
def test_a_result_read_takes_the_time_of_its_bits(
    clock: VirtualClock, clock_hz: int, read_s: float
) -> None:
    bus = FakeI2cBus(clock, [_chip(clock)], wire_hz=clock_hz)
    _boot(clock)
    before_ns = clock.now_ns()
    Registers(bus, clock, 0x29, 0).read(0x0089, 17)
    assert clock.now_ns() - before_ns == pytest.approx(read_s * 1e9, rel=0.02)


@pytest.mark.parametrize("code", [121, 110, 5])
def test_transient_errors_are_retried_so_many_times(clock: VirtualClock, code: int) -> None:
    knob = {121: "nack_transfers", 110: "timeout_transfers", 5: "io_error_transfers"}[code]
    chip = _chip(clock)
    bus = FakeI2cBus(clock, [chip])
    _boot(clock)
    registers = Registers(bus, clock, 0x29, 3)
    setattr(chip.faults, knob, 3)
    assert registers.read_int(0x010F, 2) == 0xEACC
    assert registers.retried == 3
    setattr(chip.faults, knob, 5)
    with pytest.raises(OSError, match="Errno") as caught:
        registers.read_int(0x010F, 2)
    assert caught.value.errno == code
    assert getattr(chip.faults, knob) == 1


def test_other_errors_are_not_retried(clock: VirtualClock) -> None:
    bus = FakeI2cBus(clock, [])
    bus.gone = True
    with pytest.raises(OSError, match="No such device"):
        Registers(bus, clock, 0x29, 3).read(0, 1)
    assert bus.transfers == 1


def test_a_slow_failure_is_not_retried(clock: VirtualClock) -> None:
    """Retries must not make a poll long when each time-out takes long."""

    class Slow(FakeI2cBus):
        def i2c_rdwr(self, *i2c_msgs: i2c_msg) -> None:
            clock.sleep_until_ns(clock.now_ns() + ns(0.03))
            super().i2c_rdwr(*i2c_msgs)

    bus = Slow(clock, [])
    bus.stuck = True
    with pytest.raises(OSError, match="timed out"):
        Registers(bus, clock, 0x29, 3).read(0, 1)
    assert bus.transfers == 1


def test_a_bus_that_is_not_there_says_what_to_do() -> None:
    with pytest.raises(BusDead, match=r"/dev/i2c-19 does not exist: enable I2C"):
        open_bus(19)


def test_an_open_drain_line_drives_low_or_lets_the_board_pull_up() -> None:
    factory, levels = MockFactory(), []
    pin = connect_xshut(factory, 4, levels.append)
    line = OpenDrainLine(factory, 4)
    line.on()
    assert pin.function == "input"
    line.off()
    assert pin.function == "output"
    line.on()
    line.close()
    assert levels == [True, False, True, False, True, False]
    assert len(pin.states) == 1  # no history: a robot is switched on for years


def test_a_gpiozero_output_device_is_a_line_too(clock: VirtualClock) -> None:
    factory, chip = MockFactory(), _chip(clock)
    connect_xshut(factory, 4, chip.set_xshut)
    with DigitalOutputDevice(4, initial_value=False, pin_factory=factory) as line:
        _boot(clock)
        assert not chip.answers(0x29)
        line.on()
        _boot(clock)
        assert chip.answers(0x29)
        line.off()
        assert not chip.answers(0x29)


def test_a_pin_is_reserved_by_its_line() -> None:
    factory = MockFactory()
    line = OpenDrainLine(factory, 4)
    with pytest.raises(Exception, match="already in use"):
        OpenDrainLine(factory, 4)
    line.close()
    OpenDrainLine(factory, 4)
