"""The wiring table, and what makes the lines safe."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from gpiozero.pins.pi import PiBoardInfo

from deltactl.drivers.settings import SwitchedPin
from deltactl.drivers.steps.build import lgpio_pins
from deltactl.drivers.steps.lgpio_pins import LgpioLines
from deltactl.firmware_py.install.install import hints
from deltactl.firmware_py.install.make_safe import main, make_safe
from deltactl.firmware_py.install.steps import PROGRAM
from deltactl.firmware_py.install.wiring import (
    GROUND,
    PIN_OF_GPIO,
    POWER_3V3,
    as_markdown,
    as_text,
    wiring,
)
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.errors import PulseFault
from tests.rigs import needs

ROBOT_FILE = PROGRAM / "config/zhao-2023.yaml"
BEGIN, END = "<!-- wiring table: begin -->", "<!-- wiring table: end -->"


@pytest.fixture
def robot():
    return load_robot(ROBOT_FILE)


def test_the_document_holds_the_table_of_the_robot_file(robot):
    document = (PROGRAM / "docs/wiring.md").read_text()
    table = document.split(BEGIN)[1].split(END)[0].strip()
    assert table == as_markdown(wiring(robot))


@pytest.mark.parametrize("revision", [0xA02082, 0xC03111, 0xC04170])
def test_the_header_is_that_of_gpiozero(revision):
    """Pi 3B, 4B and 5, by a table that somebody else wrote."""
    header = PiBoardInfo.from_revision(revision).headers["J8"]
    named = {pin.name: number for number, pin in header.pins.items()}
    for gpio, number in PIN_OF_GPIO.items():
        assert named[f"GPIO{gpio}"] == number
    for name, numbers in (("GND", GROUND), ("3V3", POWER_3V3)):
        assert tuple(sorted(n for n, pin in header.pins.items() if pin.name == name)) == numbers


def test_every_pin_of_the_robot_file_is_in_the_table_once(robot):
    steps, ranging = robot.steps, robot.ranging
    used = [*steps.step_pins, *steps.direction_pins, steps.enable_pin, *steps.alarm_pins]
    used += [robot.inputs.estop_pin, *ranging.xshut_pins, 2, 3]
    listed = [wire.gpio for wire in wiring(robot) if wire.gpio is not None]
    assert sorted(listed) == sorted(used)


def test_levels_follow_the_robot_file(robot):
    other = robot.model_copy(
        update={
            "steps": robot.steps.model_copy(
                update={"enable_active_high": False, "alarm_active_high": True}
            ),
            "inputs": robot.inputs.model_copy(update={"estop_active_high": False}),
        }
    )
    text = as_text(wiring(other))
    assert "low energises them" in text
    assert "high is an alarm" in text
    assert "normally open contact to ground; low stops" in text
    assert "10 kOhm" in hints(robot)[0]
    assert hints(other) == []


def test_no_emergency_stop_is_pointed_out(robot):
    without = robot.model_copy(
        update={"inputs": robot.inputs.model_copy(update={"estop_pin": None})}
    )
    assert "E-STOP" not in as_text(wiring(without))
    assert "by software only" in hints(without)[-1]


class ChipBelowLgpio:
    """The calls of lgpio that are made, with a chip that remembers levels.

    Does not model: inputs, other owners of a line (but for `busy`), time.
    """

    class error(Exception):  # noqa: N801 (named as in lgpio)
        pass

    def __init__(self, label: str = "pinctrl-bcm2711", busy: bool = False):
        self.levels: dict[int, int] = {}
        self.open = False
        self._label, self._busy = label, busy

    def gpiochip_open(self, chip: int) -> int:
        self.open = True
        return chip

    def gpio_get_chip_info(self, handle: int) -> tuple[int, int, str, str]:
        return 0, 58, "gpiochip0", self._label

    def group_claim_output(self, handle: int, gpios: list[int], levels: list[int]) -> None:
        if self._busy:
            raise self.error("GPIO busy")
        self.levels.update(zip(gpios, levels, strict=True))

    def gpiochip_close(self, handle: int) -> None:
        self.open = False


def test_steps_go_low_and_the_drives_are_released(robot):
    chip = ChipBelowLgpio()
    assert make_safe(robot, gpio=chip) == "STEP low, drives released"
    assert chip.levels == dict.fromkeys((17, 27, 22, 23, 24, 25, 5), 0)
    assert not chip.open


def test_drives_that_release_on_high(robot):
    steps = robot.steps.model_copy(update={"enable_active_high": False})
    chip = ChipBelowLgpio()
    make_safe(robot.model_copy(update={"steps": steps}), gpio=chip)
    assert chip.levels[5] == 1


def test_holding_leaves_the_enable_line_alone(robot):
    chip = ChipBelowLgpio()
    assert make_safe(robot, hold=True, gpio=chip) == "STEP low, ENA left as it was"
    assert 5 not in chip.levels


@pytest.mark.parametrize(("safe", "active_high", "level"), [
    (False, True, 0), (True, True, 1), (False, False, 1), (True, False, 0),
])  # fmt: skip
def test_outputs_of_jobs_are_put_to_their_safe_state(robot, safe, active_high, level):
    """When daemon and pulse process were killed at once: systemd's clean-up, or the next start."""
    gripper = SwitchedPin(pin=12, active_high=active_high, safe=safe)
    chip = ChipBelowLgpio()
    chip.levels[12] = 1 - level
    held = robot.model_copy(update={"outputs": {"gripper": gripper}})
    assert "outputs safe" in make_safe(held, gpio=chip)
    assert chip.levels[12] == level
    chip.levels[12] = 1 - level
    pins = lgpio_pins(held.steps, held.inputs, held.switches)
    LgpioLines(pins._replace(estop=None, alarms=[]), chip)  # what the pulse process begins with
    assert chip.levels[12] == level


def test_a_line_that_is_taken_is_said(robot):
    with pytest.raises(PulseFault, match="does another program run"):
        make_safe(robot, gpio=ChipBelowLgpio(busy=True))


@pytest.mark.parametrize("arguments", [[], ["/no/such/robot.yaml"], ["a", "b"]])
def test_it_never_fails_the_unit(arguments, capsys):
    assert main(arguments) == 0
    said = capsys.readouterr().err
    assert said.startswith("deltactl: no lines made safe: ")
    assert said.count("\n") == 1


@pytest.mark.skipif(Path("/dev/gpiochip0").exists(), reason="would move the lines of this machine")
def test_as_systemd_runs_it():
    pytest.importorskip("lgpio", reason=needs.LGPIO)
    command = [
        sys.executable,
        "-P",
        "-m",
        "deltactl.firmware_py.install.make_safe",
        str(ROBOT_FILE),
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0
    assert "/dev/gpiochip0 does not exist" in done.stderr
