"""One contract, four hosts: the same tests for every step output, simulated and real."""

from __future__ import annotations

import sys
from collections.abc import Iterator

import pytest

from deltactl.drivers.fakes.bench import FakeBench, simulated_step_output
from deltactl.drivers.fakes.gpio_chip import GpioChip
from deltactl.drivers.fakes.syscall_trap import SyscallTrap, available
from deltactl.drivers.settings import StepSettings
from deltactl.drivers.steps.build import build_step_output
from deltactl.firmware_py.named_files import find
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.clock import RealClock, VirtualClock
from tests.rigs import needs
from tests.steps.step_contract import StepOutputContract
from tests.steps.step_rig import INPUTS, STEPS, SWITCHES, Rig

ON_PINS = StepSettings(backend="gpiozero")


class TestPlayerOnAVirtualClock(StepOutputContract):
    @pytest.fixture
    def rig(self) -> Iterator[Rig]:
        clock = VirtualClock(start_ns=10**12)
        made = simulated_step_output(STEPS, INPUTS, clock, realtime=False, switches=SWITCHES)
        yield Rig(made.output, clock, 100_000, made.bench)
        made.close()


class TestGpiozeroPinsOnAVirtualClock(StepOutputContract):
    @pytest.fixture
    def rig(self) -> Iterator[Rig]:
        clock = VirtualClock()
        made = simulated_step_output(ON_PINS, INPUTS, clock, realtime=False, switches=SWITCHES)
        yield Rig(made.output, clock, 500_000, made.bench)
        made.close()


class TestPulseProcessInRealTime(StepOutputContract):
    @pytest.fixture
    def rig(self) -> Iterator[Rig]:
        clock = RealClock()
        made = simulated_step_output(STEPS, INPUTS, clock, realtime=True, switches=SWITCHES)
        yield Rig(made.output, clock, 1_000_000, made.bench)
        made.close()


class TestPulseProcessThroughLgpio(StepOutputContract):
    """What runs on a Pi, down to lgpio; only the kernel's GPIO chip is a model."""

    @pytest.fixture
    def rig(self, monkeypatch: pytest.MonkeyPatch) -> Iterator[Rig]:
        pytest.importorskip("lgpio", reason=needs.LGPIO, exc_type=ImportError)
        if not available():
            pytest.skip("needs seccomp user notification (Linux 5.14)")
        clock, chip = RealClock(), GpioChip()
        bench = FakeBench(STEPS, INPUTS, clock, pins=chip, switches=SWITCHES)
        trap = SyscallTrap({"/dev/gpiochip0": chip}, (0xB4,))
        monkeypatch.setattr(sys, "executable", trap.executable)
        output = build_step_output(STEPS, INPUTS, clock, switches=SWITCHES)
        monkeypatch.undo()
        yield Rig(output, clock, 1_000_000, bench)
        output.close()
        trap.close()
        assert not any(chip.outputs[pin] for pin in STEPS.step_pins)


def real_rig(request: pytest.FixtureRequest, backend: str) -> Iterator[Rig]:
    robot = load_robot(find(request.config.getoption("--robot")))
    settings = StepSettings.model_validate({**robot.steps.model_dump(), "backend": backend})
    clock = RealClock()
    output = build_step_output(settings, robot.inputs, clock, switches=SWITCHES)
    yield Rig(output, clock, 2_000_000)
    output.close()


@pytest.mark.hardware
class TestRealPulseProcess(StepOutputContract):
    """Moves the motors a few hundred steps to and fro."""

    @pytest.fixture
    def rig(self, request: pytest.FixtureRequest) -> Iterator[Rig]:
        yield from real_rig(request, "pulse")


@pytest.mark.hardware
class TestRealGpiozeroPins(StepOutputContract):
    """The same through gpiozero."""

    @pytest.fixture
    def rig(self, request: pytest.FixtureRequest) -> Iterator[Rig]:
        yield from real_rig(request, "gpiozero")
