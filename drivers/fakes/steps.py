"""Step outputs from settings, on the fake bench."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from deltactl.drivers.fakes.bench import FakeBench, fake_bench
from deltactl.drivers.settings import InputSettings, StepSettings
from deltactl.drivers.steps.build import (
    CHECK_AHEAD_NS,
    minimum_period_ns,
    player_settings,
    task_output,
)
from deltactl.drivers.steps.gpiozero_lines import GpiozeroLines
from deltactl.drivers.steps.output import PlayerStepOutput
from deltactl.drivers.steps.process_host import ProcessStepOutput, PulseProcess
from deltactl.drivers.steps.switches import NO_SWITCHES, Switches
from deltactl.foundation.clock import Clock, VirtualClock
from deltactl.foundation.errors import ConfigError

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
    bench = fake_bench(settings, inputs, clock, shared=own_process, switches=switches)
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
