"""The real lgpio and gpiozero on a modelled GPIO chip: how many calls, what is refused."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from deltactl.drivers.fakes.bench import FakeBench
from deltactl.drivers.fakes.gpio_chip import GET_VALUES, SET_VALUES, GpioChip
from deltactl.drivers.fakes.syscall_trap import SyscallTrap, available
from deltactl.drivers.settings import InputSettings, StepSettings
from deltactl.drivers.steps.build import build_step_output
from deltactl.drivers.steps.contract import Ticks
from deltactl.foundation.clock import RealClock
from deltactl.foundation.errors import PulseFault
from tests.rigs import needs

pytest.importorskip("lgpio", reason=needs.LGPIO, exc_type=ImportError)
pytestmark = pytest.mark.skipif(not available(), reason="needs seccomp user notification")

ROOT = Path(__file__).resolve().parents[2]
STEPS, INPUTS = StepSettings(), InputSettings()
PI_4B = (0xC03111).to_bytes(4, "big")


@pytest.fixture
def chip() -> GpioChip:
    return GpioChip()


@pytest.fixture
def trap(chip: GpioChip, monkeypatch: pytest.MonkeyPatch) -> Iterator[SyscallTrap]:
    revision = "/proc/device-tree/system/linux,revision"
    trap = SyscallTrap({"/dev/gpiochip0": chip}, (0xB4,), {revision: PI_4B})
    monkeypatch.setattr(sys, "executable", trap.executable)
    yield trap
    trap.close()


@pytest.mark.usefixtures("trap")
def test_three_motors_step_in_one_call_up_and_one_down(chip: GpioChip) -> None:
    bench = FakeBench(STEPS, INPUTS, RealClock(), pins=chip)
    output = build_step_output(STEPS, INPUTS, RealClock())
    output.enable()
    before = chip.calls[SET_VALUES]
    start_ns = time.monotonic_ns() + 20_000_000
    output.push(Ticks(start_ns + 1_000_000 * np.arange(50), np.full((50, 3), -1, np.int8)))
    while output.status().queued:
        time.sleep(0.01)
    time.sleep(0.01)
    assert bench.counts() == output.status().counts == (-50, -50, -50)
    assert chip.calls[SET_VALUES] - before == 100
    assert chip.calls[GET_VALUES] >= 50  # e-stop and alarms in one call, before every step
    output.close()


@pytest.mark.usefixtures("trap")
def test_a_chip_that_is_not_the_header_is_refused(chip: GpioChip) -> None:
    chip.label = "gpio-brcmstb@107d508500"
    for named in (None, 0):
        settings = STEPS.model_copy(update={"chip": named})
        with pytest.raises(PulseFault, match=r"/dev/gpiochip0 is 'gpio-brcmstb.* 40-pin header"):
            build_step_output(settings, INPUTS, RealClock())


@pytest.mark.usefixtures("trap")
def test_lines_that_cannot_be_had_are_named(chip: GpioChip) -> None:
    chip.lines = 20
    with pytest.raises(PulseFault, match=r"GPIO 26, 6, 13, 19 cannot be claimed"):
        build_step_output(STEPS, INPUTS, RealClock())


ON_PINS = """
import time
import numpy as np
from deltactl.drivers.settings import InputSettings, StepSettings
from deltactl.drivers.steps.build import build_step_output
from deltactl.drivers.steps.contract import Ticks
from deltactl.foundation.clock import RealClock

output = build_step_output(StepSettings(backend="gpiozero"), InputSettings(), RealClock())
output.enable()
start_ns = time.monotonic_ns() + 20_000_000
output.push(Ticks(start_ns + 2_000_000 * np.arange(30), np.ones((30, 3), np.int8)))
while output.status().queued:
    time.sleep(0.01)
    output.beat()
time.sleep(0.02)
print(*output.status().counts)
output.close()
"""


def test_gpiozero_moves_the_same_drives(chip: GpioChip, trap: SyscallTrap, tmp_path: Path) -> None:
    bench = FakeBench(STEPS, INPUTS, RealClock(), pins=chip)
    done = subprocess.run(
        [trap.executable, "-c", ON_PINS],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=30,
        check=False,
    )
    assert (done.stdout.split(), done.stderr) == (["30", "30", "30"], "")
    assert bench.counts() == (30, 30, 30)
    assert bench.memory.lost() == (0, 0, 0)
    assert not list(tmp_path.iterdir())  # lgpio left its pipe elsewhere
