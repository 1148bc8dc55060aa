"""The fake bench: its wires, its button, and its memory of where the motors were."""

from __future__ import annotations

import numpy as np
import pytest
from gpiozero import Device, InputDevice, OutputDevice
from hypothesis import given
from hypothesis import strategies as st

from deltactl.drivers.fakes.bench import FakeBench
from deltactl.drivers.fakes.lines import BENCH_BYTES, ROWS, BenchMemory, FakeLines
from deltactl.drivers.fakes.mock_pins import WiredFactory
from deltactl.drivers.fakes.step_drive import DriveLimits, SimulatedDrive
from deltactl.drivers.settings import InputSettings, StepSettings
from deltactl.drivers.steps.gpiozero_pins import alarm_inputs, estop_input, home_switches
from deltactl.drivers.steps.lines import ENABLE_BIT
from deltactl.foundation.clock import VirtualClock, sleep_s
from deltactl.foundation.errors import ConfigError

STEPS, INPUTS = StepSettings(), InputSettings()


@pytest.fixture
def bench() -> FakeBench:
    return FakeBench(STEPS, INPUTS, VirtualClock())


def test_output_devices_move_the_drives() -> None:
    clock = VirtualClock()
    bench = FakeBench(STEPS, INPUTS, clock)
    pins = bench.pin_factory
    enable, direction, step = (
        OutputDevice(pin, pin_factory=pins)
        for pin in (STEPS.enable_pin, STEPS.direction_pins[1], STEPS.step_pins[1])
    )
    enable.on()
    direction.on()
    sleep_s(clock, 0.3)
    for _ in range(3):
        step.on()
        sleep_s(clock, 0.001)
        step.off()
        sleep_s(clock, 0.001)
    assert bench.counts() == (0, 3, 0)
    assert bench.memory.edges() == (0, 3, 0)


def test_a_broken_estop_wire_reads_as_pressed(bench: FakeBench) -> None:
    estop = estop_input(INPUTS, bench.pin_factory)
    assert estop is not None
    assert not estop.active
    bench.press_estop()
    assert estop.active
    bench.release_estop()
    assert not estop()
    bench.pin_factory.drive(INPUTS.estop_pin, None)  # the pull-up is all that is left
    assert estop.active


def test_alarm_wires_follow_the_drives(bench: FakeBench) -> None:
    alarms = alarm_inputs(STEPS, bench.pin_factory)
    bench.trip(3)
    assert [alarm.active for alarm in alarms] == [False, False, True]
    assert [alarm.level for alarm in alarms] == [True, True, False]


def test_absent_inputs_are_absent() -> None:
    assert estop_input(InputSettings(estop_pin=None)) is None
    assert alarm_inputs(StepSettings(alarm_pins=None)) == ()
    assert home_switches(None, False) == ()


def test_home_switches_pull_to_ground(bench: FakeBench) -> None:
    switches = home_switches((7, 8, 12), False, bench.pin_factory)
    bench.pin_factory.drive(8, False)
    assert [switch.active for switch in switches] == [False, True, False]
    for switch in switches:
        switch.close()


def test_a_pin_in_use_is_named_and_the_others_given_back(bench: FakeBench) -> None:
    blocker = InputDevice(12, pin_factory=bench.pin_factory)
    with pytest.raises(ConfigError, match="GPIO 12"):
        home_switches((7, 8, 12), False, bench.pin_factory)
    blocker.close()
    for switch in home_switches((7, 8, 12), False, bench.pin_factory):
        switch.close()


def test_gpiozeros_global_factory_is_left_alone(bench: FakeBench) -> None:
    assert Device.pin_factory is None


def test_a_wired_pin_keeps_no_history() -> None:
    factory = WiredFactory()
    led = OutputDevice(17, pin_factory=factory)
    for _ in range(100):
        led.toggle()
    assert factory.pin(17).states == []


def test_a_driven_wire_wins_over_a_pull() -> None:
    factory = WiredFactory()
    factory.drive(17, False)
    line = InputDevice(17, pull_up=True, pin_factory=factory)
    assert factory.pin(17).state is False
    factory.drive(17, None)
    assert factory.pin(17).state is True
    line.close()


class _Time:
    def __init__(self) -> None:
        self.now_ns = 0


@given(st.lists(st.integers(100_000, 10_000_000), min_size=1, max_size=60), st.data())
def test_the_history_knows_where_the_motors_were(gaps_ns: list[int], data: st.DataObject) -> None:
    time, memory = _Time(), BenchMemory(bytearray(BENCH_BYTES))
    drives = [SimulatedDrive(DriveLimits(enable_ns=0)) for _ in range(3)]
    lines = FakeLines(memory, lambda: time.now_ns, drives=drives)
    lines.write(ENABLE_BIT | 0b001_000, ENABLE_BIT | 0b111_000)
    edges_ns = np.cumsum(gaps_ns)
    for t_ns in edges_ns:
        time.now_ns = int(t_ns)
        lines.write(0b011, 0b011)
        time.now_ns += 5_000
        lines.write(0, 0b011)
    asked_ns = data.draw(st.integers(0, int(edges_ns[-1]) + 10))
    steps = int((edges_ns <= asked_ns).sum())
    assert memory.counts_at(asked_ns) == (steps, -steps, 0)
    assert memory.counts() == (len(gaps_ns), -len(gaps_ns), 0)


def test_a_history_that_has_come_round_begins_at_the_oldest_kept() -> None:
    memory = BenchMemory(bytearray(BENCH_BYTES))
    drives = [SimulatedDrive() for _ in range(3)]
    for t_ns in range(ROWS + 1000):
        drives[0].position_steps = t_ns
        memory.publish(t_ns, drives)
    assert memory.counts_at(ROWS) == (ROWS, 0, 0)
    oldest = memory.step_times()[0]
    assert memory.counts_at(0) == memory.counts_at(oldest) == (oldest, 0, 0)
