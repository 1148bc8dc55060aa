"""The whole fake bench: pins, drives, alarm wires and the e-stop button of one simulated robot."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from mmap import mmap
from pathlib import Path
from typing import Protocol

from deltactl.drivers.fakes.lines import BENCH_BYTES, BenchMemory, Counts, FakeLines, FakeWiring
from deltactl.drivers.fakes.mock_pins import WiredFactory
from deltactl.drivers.settings import InputSettings, StepSettings
from deltactl.drivers.steps.build import (
    CHECK_AHEAD_NS,
    minimum_period_ns,
    player_settings,
    task_output,
)
from deltactl.drivers.steps.gpiozero_pins import GpiozeroLines, InputLine, named_inputs
from deltactl.drivers.steps.hosts import ProcessStepOutput, PulseProcess
from deltactl.drivers.steps.lines import (
    DIRECTION_SHIFT,
    ENABLE_BIT,
    NO_SWITCHES,
    SWITCH_SHIFT,
    Switches,
)
from deltactl.drivers.steps.output import PlayerStepOutput
from deltactl.foundation.clock import Clock, VirtualClock
from deltactl.foundation.errors import ConfigError


def fake_wiring(settings: StepSettings, inputs: InputSettings) -> FakeWiring:
    """A bench that is wired as the settings say."""
    return FakeWiring(
        enable_level=int(settings.enable_active_high),
        estop_level=int(inputs.estop_active_high),
        alarm_level=int(settings.alarm_active_high),
        inverted=sum(mirrored << motor for motor, mirrored in enumerate(settings.inverted)),
    )


class Pins(Protocol):
    """Where wires end: mock pins of gpiozero, or a GPIO chip."""

    def connect(self, pin: int, on_level: Callable[[bool], None]) -> None:
        """Call `on_level` when the program puts a level on this pin."""

    def drive(self, pin: int, level: bool | None) -> None:
        """A circuit puts a level on this pin, or lets it go (None)."""


class FakeBench:
    """Hands on the simulated robot: press the button, trip a drive, see where the motors are.

    `lines` moves the drives directly, `pin_factory` through gpiozero devices; a bench in
    `shared` memory is moved by a pulse process, and both are then for looking only.
    """

    def __init__(
        self,
        settings: StepSettings,
        inputs: InputSettings,
        clock: Clock,
        *,
        shared: bool = False,
        pins: Pins | None = None,
        switches: Switches = NO_SWITCHES,
    ):
        self.wiring = fake_wiring(settings, inputs)
        self.descriptor = os.memfd_create("deltactl-bench") if shared else None
        if self.descriptor is not None:
            os.ftruncate(self.descriptor, BENCH_BYTES)
            self._block: mmap | bytearray = mmap(self.descriptor, BENCH_BYTES)
        else:
            self._block = bytearray(BENCH_BYTES)
        self.memory = BenchMemory(self._block)
        self.lines = FakeLines(self.memory, clock.now_ns, self.wiring)
        self.pin_factory = WiredFactory()
        self._pins: Pins = pins or self.pin_factory
        self._settings, self._inputs = settings, inputs
        self._switches = switches
        self._connect()

    def counts(self) -> Counts:
        """Where the motors are [microsteps]."""
        return self.memory.counts()

    def counts_at(self, t_ns: int) -> Counts:
        """Where the motors were at a time (65536 steps back at most)."""
        return self.memory.counts_at(t_ns)

    def press_estop(self) -> None:
        """Press the e-stop button (or cut its wire)."""
        self._set_estop(True)

    def release_estop(self) -> None:
        """Turn the e-stop button until it springs back."""
        self._set_estop(False)

    def outputs(self) -> dict[str, bool]:
        """Which switched outputs are on: where the gripper and the valve are."""
        return self._switches.states(self.memory.switched)

    def set_input(self, name: str, on: bool) -> None:
        """Put a named input on or off: a part has come."""
        wired = self._inputs.named[name]
        self._pins.drive(wired.pin, on == wired.active_high)

    def wired_inputs(self, on: Mapping[str, bool]) -> dict[str, InputLine]:
        """The named inputs as the program reads them, some of them on to begin with."""
        for name, is_on in on.items():
            self.set_input(name, is_on)
        return named_inputs(self._inputs, self.pin_factory)

    def trip(self, motor: int) -> None:
        """Make the drive of a motor (1 to 3) raise its alarm."""
        self.memory.ask_trips(1 << motor - 1)
        self._tell_drives()

    def slip(self, motor: int, steps: int) -> None:
        """Make a motor (1 to 3) fall so many steps behind, without an alarm."""
        self.memory.ask_slip(motor - 1, steps)
        self._tell_drives()

    def stall(self, motor: int, held: bool = True) -> None:
        """Hold the rotor of a motor (1 to 3), or let it go."""
        self.memory.ask_stall(motor - 1, held)
        self._tell_drives()

    def release_drives(self) -> str:
        """Whoever had the lines is gone, and another puts ENA where it holds nothing."""
        self.memory.energised = False
        self.memory.switched = self._switches.safe_levels
        return "STEP low, drives released"

    def close(self) -> None:
        """Give the shared memory back; where the motors were can still be asked."""
        self.pin_factory.close()
        if isinstance(self._block, mmap) and self.descriptor is not None:
            kept = bytearray(self._block)
            self.memory.release()
            self._block.close()
            os.close(self.descriptor)
            self.descriptor, self._block, self.memory = None, kept, BenchMemory(kept)

    def _tell_drives(self) -> None:
        """A pulse process finds it in the memory by itself."""
        if self.descriptor is None:
            self.lines.refresh()

    def _connect(self) -> None:
        """Solder the drives to the pins."""
        settings, pins = self._settings, self._pins
        for motor in range(3):
            pins.connect(settings.step_pins[motor], partial(self._level, 1 << motor))
            direction_bit = 1 << (DIRECTION_SHIFT + motor)
            pins.connect(settings.direction_pins[motor], partial(self._level, direction_bit))
        if settings.enable_pin is not None:
            pins.connect(settings.enable_pin, partial(self._level, ENABLE_BIT))
        for place, pin in enumerate(self._switches.numbers, SWITCH_SHIFT):
            pins.connect(pin, partial(self._level, 1 << place))
        for name in self._inputs.named:
            self.set_input(name, False)
        self.lines.on_alarms = self._show_alarms
        self._show_alarms(0)
        self._set_estop(False)

    def _level(self, bit: int, high: bool) -> None:
        self.lines.write(bit * high, bit)

    def _set_estop(self, pressed: bool) -> None:
        self.memory.estop_pressed = pressed
        if self._inputs.estop_pin is not None:
            level = pressed == bool(self.wiring.estop_level)
            self._pins.drive(self._inputs.estop_pin, level)

    def _show_alarms(self, alarms: int) -> None:
        for motor, pin in enumerate(self._settings.alarm_pins or ()):
            level = bool(alarms >> motor & 1) == bool(self.wiring.alarm_level)
            self._pins.drive(pin, level)


FAKE = "deltactl.drivers.fakes.lines:of_config"
"""What opens the lines in the pulse process, see pulse_main.open_lines."""


@dataclass(frozen=True)
class SimulatedSteps:
    """A step output on the fake bench, and the bench."""

    output: PlayerStepOutput
    bench: FakeBench

    def close(self) -> None:
        """Close both."""
        self.output.close()
        self.bench.close()


def simulated_step_output(
    settings: StepSettings,
    inputs: InputSettings,
    clock: Clock,
    *,
    realtime: bool,
    switches: Switches = NO_SWITCHES,
    board_path: Path | None = None,
) -> SimulatedSteps:
    """The same backends on simulated drives.

    realtime False: on any clock, the pulse backend's player runs in this process.
    realtime True: on the real clock, a pulse process plays on fake lines.
    The gpiozero backend runs in this process in both cases, on mock pins.
    """
    if realtime and isinstance(clock, VirtualClock):
        raise ConfigError("a virtual clock does not run in real time; use the real clock")
    own_process = realtime and settings.backend == "pulse"
    bench = FakeBench(settings, inputs, clock, shared=own_process, switches=switches)
    if not own_process:
        on_pins = settings.backend == "gpiozero"
        pins = bench.pin_factory
        lines = GpiozeroLines(settings, inputs, pins, switches) if on_pins else bench.lines
        return SimulatedSteps(task_output(settings, inputs, clock, lines, switches), bench)
    assert bench.descriptor is not None
    wires = {"lines": FAKE, "bench": bench.descriptor, "wiring": bench.wiring}
    process = PulseProcess(
        player_settings(settings, inputs, CHECK_AHEAD_NS, switches=switches),
        wires,
        (bench.descriptor,),
        board_path,
    )
    output = ProcessStepOutput(process, clock, minimum_period_ns(settings, clock))
    return SimulatedSteps(output, bench)
