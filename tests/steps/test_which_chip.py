"""The chip behind the header is found by its label, by every user of GPIO."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from deltactl.drivers.fakes.gpio_chip import GpioChip
from deltactl.drivers.fakes.syscall_trap import SyscallTrap, available
from tests.rigs import needs

pytest.importorskip("lgpio", reason=needs.LGPIO, exc_type=ImportError)
pytestmark = pytest.mark.skipif(not available(), reason="needs seccomp user notification")

ROOT = Path(__file__).resolve().parents[2]
PI_4, PI_5 = 0xC03111, 0xC04170
REVISION = "/proc/device-tree/system/linux,revision"
BCM2711, RP1, OTHER = "pinctrl-bcm2711", "pinctrl-rp1", "gpio-brcmstb@107d508500"

ALL_USERS = """
import sys
from deltactl.drivers.steps.lgpio_pins import lgpio_pin_factory
from deltactl.drivers.settings import InputSettings, StepSettings
from deltactl.drivers.steps.build import build_step_output, release_drives
from deltactl.foundation.clock import RealClock
from deltactl.foundation.errors import DeltactlError
from gpiozero import DigitalOutputDevice

settings = StepSettings(chip=eval(sys.argv[1]), backend=sys.argv[2])
try:
    factory = lgpio_pin_factory(settings.chip)
    DigitalOutputDevice(4, pin_factory=factory).on()
    build_step_output(settings, InputSettings(), RealClock()).close()
    release_drives(settings, InputSettings())
    print(factory.chip)
except DeltactlError as error:
    print(type(error).__name__, error)
"""


def used(revision: int, labels: dict[int, str], named: int | None, backend: str = "pulse") -> str:
    """What all users of GPIO end with on a Pi whose chips have these labels."""
    chips = {number: GpioChip(label) for number, label in labels.items()}
    devices = {f"/dev/gpiochip{number}": chip for number, chip in chips.items()}
    trap = SyscallTrap(devices, (0xB4,), {REVISION: revision.to_bytes(4, "big")})
    try:
        done = subprocess.run(
            [trap.executable, "-c", ALL_USERS, repr(named), backend],
            capture_output=True, text=True, timeout=60, cwd=ROOT, check=False,
        )  # fmt: skip
    finally:
        trap.close()
    assert done.returncode == 0, done.stderr
    said = done.stdout.strip()
    for number, chip in chips.items():
        assert bool(chip.outputs) == (said == str(number)), f"lines of chip {number}"
    return said


@pytest.mark.study
@pytest.mark.parametrize(
    ("revision", "labels", "expected"),
    [
        (PI_4, {0: BCM2711, 1: "raspberrypi-exp-gpio"}, "0"),
        (PI_5, {0: OTHER, 1: OTHER, 4: RP1}, "4"),
        (PI_5, {0: RP1, 4: OTHER}, "0"),
        (PI_4, {0: "mcp23017", 2: BCM2711}, "2"),
    ],
)
def test_it_is_found_by_its_label(revision: int, labels: dict[int, str], expected: str) -> None:
    assert used(revision, labels, None) == expected


def test_gpiozero_steps_on_it_too() -> None:
    assert used(PI_5, {0: OTHER, 3: RP1}, None, "gpiozero") == "3"


@pytest.mark.study
def test_a_chip_that_the_robot_file_names_is_the_one() -> None:
    assert used(PI_5, {0: RP1, 4: RP1}, 4) == "4"


@pytest.mark.study
@pytest.mark.parametrize(
    ("labels", "named", "device"),
    [
        ({0: OTHER}, None, "/dev/gpiochip0"),
        ({0: OTHER, 4: RP1}, 0, "/dev/gpiochip0"),
        ({0: RP1}, 4, "/dev/gpiochip4"),
    ],
)
def test_one_that_is_not_the_header_is_refused_by_its_device(
    labels: dict[int, str], named: int | None, device: str
) -> None:
    said = used(PI_5, labels, named)
    assert said.startswith("ConfigError")
    assert device in said
    assert "\n" not in said
