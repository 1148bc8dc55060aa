"""What the backends do that their contract does not say."""

from __future__ import annotations

import time

import numpy as np
import pytest
from gpiozero import OutputDevice

from deltactl.drivers.fakes.bench import FakeBench, simulated_step_output
from deltactl.drivers.settings import InputSettings, StepSettings
from deltactl.drivers.steps.build import (
    build_step_output,
    lgpio_pins,
    minimum_period_ns,
    player_settings,
)
from deltactl.drivers.steps.contract import OutputState, Ticks
from deltactl.drivers.steps.hosts import TaskHost, TaskStepOutput
from deltactl.drivers.steps.lines import ALARM_BITS, ESTOP_BIT
from deltactl.drivers.steps.output import PlayerStepOutput
from deltactl.foundation.clock import RealClock, Task, TaskHandle, VirtualClock, sleep_s
from deltactl.foundation.errors import ConfigError, LimitExceeded, PulseFault

INPUTS = InputSettings()
ON_PINS = StepSettings(backend="gpiozero")


def ticks(start_ns: int, count: int, period_ns: int) -> Ticks:
    return Ticks(start_ns + period_ns * np.arange(count), np.ones((count, 3), dtype=np.int8))


def test_gpiozero_in_real_time_refuses_what_it_cannot_keep() -> None:
    made = simulated_step_output(ON_PINS, INPUTS, RealClock(), realtime=True)
    made.output.enable()
    with pytest.raises(LimitExceeded, match="2000 us or more"):
        made.output.push(ticks(time.monotonic_ns(), 3, 1_000_000))
    made.output.push(ticks(time.monotonic_ns() + 5_000_000, 20, 2_000_000))
    while made.output.status().queued:
        time.sleep(0.01)
        made.output.beat()
    gaps_ns = np.diff(made.output.take_sent().due_ns)
    assert gaps_ns.min() >= 0.9 * 2_000_000 - 1
    assert made.bench.counts() == made.output.status().counts == (20, 20, 20)
    made.close()


@pytest.mark.parametrize(
    ("settings", "expected_ns"),
    [
        (StepSettings(), 50_000),
        (StepSettings(pulse_width_us=100.0, direction_setup_us=20.0), 220_000),
        (ON_PINS, 50_000),
    ],
)
def test_the_shortest_period_is_known_before_anything_moves(
    settings: StepSettings, expected_ns: int
) -> None:
    assert minimum_period_ns(settings, VirtualClock()) == expected_ns
    made = simulated_step_output(settings, INPUTS, VirtualClock(), realtime=False)
    assert made.output.minimum_period_ns == expected_ns
    made.close()


def test_pins_taken_by_another_device_are_refused_in_one_line() -> None:
    bench = FakeBench(ON_PINS, INPUTS, VirtualClock())
    blocker = OutputDevice(22, pin_factory=bench.pin_factory)
    with pytest.raises(ConfigError, match="step pins cannot be used"):
        build_step_output(ON_PINS, INPUTS, VirtualClock(), pin_factory=bench.pin_factory)
    blocker.close()
    build_step_output(ON_PINS, INPUTS, VirtualClock(), pin_factory=bench.pin_factory).close()


def test_polarities_reach_the_player() -> None:
    usual = player_settings(StepSettings(), INPUTS)
    assert usual.input_mask == ALARM_BITS | ESTOP_BIT
    assert usual.input_idle == ALARM_BITS
    other = player_settings(
        StepSettings(alarm_active_high=True, inverted=(True, False, True)),
        InputSettings(estop_active_high=False),
    )
    assert (other.input_idle, other.inverted) == (ESTOP_BIT, 0b101)
    bare = player_settings(StepSettings(alarm_pins=None), InputSettings(estop_pin=None))
    assert bare.input_mask == 0
    assert lgpio_pins(StepSettings(enable_pin=None), INPUTS).outputs == [17, 27, 22, 23, 24, 25]


@pytest.mark.parametrize("backend", ["pulse", "gpiozero"])
def test_any_polarity_moves_the_same_way(backend: str) -> None:
    settings = StepSettings.model_validate(
        {
            "backend": backend,
            "enable_active_high": False,
            "alarm_active_high": True,
            "inverted": (True, False, True),
        }
    )
    clock = VirtualClock()
    made = simulated_step_output(
        settings, InputSettings(estop_active_high=False), clock, realtime=False
    )
    made.output.enable()
    made.output.push(ticks(clock.now_ns() + 1_000_000, 8, 1_000_000))
    sleep_s(clock, 0.05)
    assert made.bench.counts() == made.output.status().counts == (8, 8, 8)
    made.bench.trip(1)
    made.output.status()
    assert made.output.status().reason == "alarm motor1"
    made.close()


class BrokenLines:
    """Lines that fail after so many writes."""

    def __init__(self, good: int):
        self.good = good

    def write(self, levels: int, mask: int) -> None:
        self.good -= 1
        if self.good < 0:
            raise PulseFault("the wire burned through")

    def read(self) -> int:
        return 0b1110

    def close(self) -> None:
        pass


def test_lines_that_fail_end_the_output() -> None:
    clock = VirtualClock()
    settings = player_settings(StepSettings(), INPUTS)
    output = TaskStepOutput(BrokenLines(good=6), settings, clock, 50_000)
    output.enable()
    output.push(ticks(clock.now_ns() + 1_000_000, 8, 1_000_000))
    sleep_s(clock, 0.05)
    assert output.status().state is OutputState.STOPPED
    assert output.status().queued == 0
    assert "burned through" in output.status().reason
    with pytest.raises(PulseFault, match="burned through"):
        output.push(ticks(clock.now_ns(), 1, 1_000_000))
    with pytest.raises(PulseFault, match="burned through"):
        output.close()
    output.close()
    assert output.status().counts == (1, 1, 1)


class CountingClock(VirtualClock):
    """Remembers which tasks were started."""

    def __init__(self) -> None:
        self.started: list[str] = []
        super().__init__()

    def start(self, name: str, task: Task) -> TaskHandle:
        self.started.append(name)
        return super().start(name, task)


def test_one_task_plays_however_often_ticks_come() -> None:
    clock = CountingClock()
    host = TaskHost(BrokenLines(good=1000), player_settings(StepSettings(), INPUTS), clock)
    output = PlayerStepOutput(host, clock, 50_000)
    output.enable()
    begin_ns = clock.now_ns() + 1_000_000
    for part in range(3):
        output.push(ticks(begin_ns + part * 4_000_000, 4, 1_000_000))
    assert clock.started.count("pulses") == 1
    sleep_s(clock, 0.05)
    assert output.status().counts == (12, 12, 12)
    output.push(ticks(clock.now_ns() + 1_000_000, 4, 1_000_000))
    assert clock.started.count("pulses") == 2
    sleep_s(clock, 0.05)
    output.close()
    host.play()
    assert clock.started.count("pulses") == 2


def test_an_estop_is_noticed_though_nobody_asks_and_nothing_moves() -> None:
    clock = VirtualClock()
    made = simulated_step_output(StepSettings(), INPUTS, clock, realtime=False)
    made.output.enable()
    made.bench.press_estop()
    sleep_s(clock, 0.03)
    made.bench.release_estop()
    assert made.output.status().reason == "e-stop"
    made.close()
