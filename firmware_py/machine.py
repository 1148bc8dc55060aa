"""The machine a controller drives: clock, step output, sensors, inputs; real or simulated."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from deltactl.drivers.fakes.bench import FakeBench
from deltactl.drivers.fakes.current_drives import FakeCurrentDrives
from deltactl.drivers.fakes.ranging_bench import RangingRig
from deltactl.drivers.ranging.contract import RangingSensors
from deltactl.drivers.steps.contract import StepOutput
from deltactl.drivers.steps.lines import NO_SWITCHES, Switches
from deltactl.firmware_py.servo.output import ServoOutput
from deltactl.firmware_py.simulation.world import SimulatedRobot
from deltactl.foundation.clock import Clock


@dataclass(frozen=True)
class Machine:
    """Everything below the controller. `world` is there in simulation only."""

    clock: Clock
    output: StepOutput
    sensors: RangingSensors
    world: SimulatedRobot | None = None
    bench: FakeBench | None = None
    """The simulated drives and buttons, in simulation only."""
    rig: RangingRig | None = None
    """The simulated sensors and their bus, in simulation only."""
    servo: ServoOutput | None = None
    """The same as `output` on a robot with servo drives: what only they can tell."""
    drives: FakeCurrentDrives | None = None
    """The simulated servo drives, in simulation only."""
    switches: Switches = NO_SWITCHES
    """The outputs that jobs switch; what they are put to goes through `output`."""
    inputs: Mapping[str, Callable[[], bool]] = field(default_factory=dict)
    """What jobs wait for, true while on."""
    home_switches: tuple[Callable[[], bool], ...] = ()
    """One for each arm, true while pressed; empty when the robot has none."""
    release: Callable[[], str] = lambda: "nobody is left who could release the drives"
    """Releases the drives without the output, when that is gone; says what was done."""
    closers: tuple[Callable[[], None], ...] = field(default_factory=tuple)

    @property
    def simulated(self) -> bool:
        """Whether this is the simulated robot."""
        return self.world is not None

    def close(self) -> None:
        """Stop and give everything back, in order, whatever fails."""
        for closer in (self.output.close, self.sensors.close, *self.closers):
            try:
                closer()
            except OSError:
                continue


MODEL_FILE = Path("/proc/device-tree/model")


def is_raspberry_pi(model_file: Path = MODEL_FILE) -> bool:
    """Whether this machine calls itself a Raspberry Pi."""
    try:
        return "Raspberry Pi" in model_file.read_text(errors="replace")
    except OSError:
        return False
