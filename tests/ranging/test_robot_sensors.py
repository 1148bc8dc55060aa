"""Opening the sensors of a real machine, as far as a machine without any can show it."""

from __future__ import annotations

from pathlib import Path

import pytest
from gpiozero import OutputDevice
from gpiozero.pins.mock import MockFactory
from smbus2 import i2c_msg

from deltactl.drivers.fakes.i2c_bus import FakeI2cBus
from deltactl.drivers.ranging import robot_sensors
from deltactl.drivers.ranging.robot_sensors import open_robot_sensors
from deltactl.drivers.settings import RangingSettings
from deltactl.firmware_py.controller.build import real_machine
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.clock import VirtualClock
from deltactl.foundation.errors import BusDead, SensorFault


def test_without_the_bus_the_pins_are_not_touched() -> None:
    factory = MockFactory()
    with pytest.raises(BusDead, match=r"/dev/i2c-19 does not exist"):
        open_robot_sensors(RangingSettings(bus=19), VirtualClock(), factory)
    assert not factory.pins


def test_a_pin_in_use_gives_everything_back(monkeypatch: pytest.MonkeyPatch) -> None:
    clock, factory = VirtualClock(), MockFactory()
    bus = FakeI2cBus(clock, [])
    monkeypatch.setattr(robot_sensors, "open_bus", lambda number: bus)
    with OutputDevice(21, pin_factory=factory):
        with pytest.raises(SensorFault, match=r"GPIO 4, 20, 21\) cannot be had: .*in use"):
            open_robot_sensors(RangingSettings(), clock, factory)
        with pytest.raises(OSError, match="Bad file descriptor"):
            bus.i2c_rdwr(i2c_msg.read(0x29, 1))
    bank = open_robot_sensors(RangingSettings(), clock, factory)
    bank.close()


def test_opened_sensors_are_in_reset_until_they_are_started(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    clock, factory = VirtualClock(), MockFactory()
    monkeypatch.setattr(robot_sensors, "open_bus", lambda number: FakeI2cBus(clock, []))
    bank = open_robot_sensors(RangingSettings(), clock, factory)
    for number in RangingSettings().xshut_pins:
        pin = factory.pin(number)
        assert (pin.function, pin.state) == ("output", 0)
    assert bank.health() == dict.fromkeys("xyz", "off")
    bank.close()


def test_a_robot_without_sensors_opens_neither_bus_nor_pins(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    factory = MockFactory()
    monkeypatch.setattr("deltactl.drivers.steps.lgpio_pins.lgpio_pin_factory", lambda _: factory)
    robot = load_robot(Path(__file__).parents[2] / "config" / "zhao-2023.yaml")
    steps = robot.steps.model_copy(update={"backend": "gpiozero"})
    machine = real_machine(robot.model_copy(update={"sensors": None, "steps": steps}))
    try:
        machine.sensors.start()
        assert machine.sensors.poll() == []
        assert not set(robot.ranging.xshut_pins) & set(factory.pins)
    finally:
        machine.close()
