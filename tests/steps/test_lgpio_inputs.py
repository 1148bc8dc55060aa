"""How the lines through lgpio claim and read their inputs: pulled up, and each bit in its place."""

from __future__ import annotations

import numpy as np
import pytest

from deltactl.drivers.settings import InputSettings, StepSettings
from deltactl.drivers.steps.build import lgpio_pins, player_settings, release_drives
from deltactl.drivers.steps.lgpio_pins import LgpioLines
from deltactl.drivers.steps.lines import ALARM_BITS, ALARM_SHIFT, ENABLE_BIT, ESTOP_BIT
from deltactl.foundation.errors import PulseFault
from tests.steps.step_rig import SWITCHES

OPEN = 0b1111


class Gpio:
    """lgpio with nothing behind it: notes what is asked, and says the levels it was given.

    As in lgpio, the bits of a group come in the order in which its lines were claimed.
    """

    SET_PULL_UP, SET_PULL_DOWN, SET_PULL_NONE = 32, 64, 128
    error = RuntimeError

    def __init__(self, levels: dict[int, int] | None = None, busy: tuple[int, ...] = ()):
        self.levels = levels or {}
        self.busy = busy
        self.inputs: list[int] = []
        self.flags = 0
        self.outputs: dict[int, int] = {}
        self.written: list[tuple[int, int]] = []
        self.leaders: list[int] = []
        self.open = 0

    def gpiochip_open(self, chip: int) -> int:
        self.open += 1
        return 7

    def gpiochip_close(self, handle: int) -> None:
        assert handle == 7
        self.open -= 1

    def gpio_get_chip_info(self, handle: int) -> tuple[int, int, str, str]:
        return 0, 54, "gpiochip0", "pinctrl-bcm2711"

    def group_claim_input(self, handle: int, group: list[int], flags: int) -> None:
        if set(group) & set(self.busy):
            raise RuntimeError("GPIO busy")
        self.inputs, self.flags = list(group), flags

    def group_claim_output(self, handle: int, group: list[int], levels: list[int]) -> None:
        if set(group) & set(self.busy):
            raise RuntimeError("GPIO busy")
        self.outputs |= dict(zip(group, levels, strict=True))

    def group_read(self, handle: int, leader: int) -> tuple[int, int]:
        assert leader == self.inputs[0]
        pulled = int(self.flags == self.SET_PULL_UP)
        bits = [self.levels.get(pin, pulled) << bit for bit, pin in enumerate(self.inputs)]
        return len(self.inputs), sum(bits)

    def group_write(self, handle: int, leader: int, levels: int, mask: int) -> None:
        self.written.append((levels, mask))
        self.leaders.append(leader)


STEPS = StepSettings()


def lines(gpio: Gpio, steps: StepSettings = STEPS, estop_pin: int | None = 26) -> LgpioLines:
    return LgpioLines(lgpio_pins(steps, InputSettings(estop_pin=estop_pin)), gpio)


def test_an_open_wire_of_the_estop_reads_as_pressed() -> None:
    """Nothing drives the line: its pull-up does, and that is a stop."""
    gpio = Gpio({6: 1, 13: 1, 19: 1})
    levels = lines(gpio).read()
    assert gpio.inputs == [26, 6, 13, 19]
    settings = player_settings(STEPS, InputSettings())
    assert (levels ^ settings.input_idle) & settings.input_mask == ESTOP_BIT
    closed = lines(Gpio({26: 0})).read()
    assert (closed ^ settings.input_idle) & settings.input_mask == 0


@pytest.mark.parametrize("estop_pin", [26, None])
@pytest.mark.parametrize("motor", [0, 1, 2])
def test_each_alarm_has_its_own_bit_with_an_estop_and_without(
    estop_pin: int | None, motor: int
) -> None:
    gpio = Gpio({26: 0, (6, 13, 19)[motor]: 0})
    settings = player_settings(STEPS, InputSettings(estop_pin=estop_pin))
    wrong = (lines(gpio, estop_pin=estop_pin).read() ^ settings.input_idle) & settings.input_mask
    assert wrong == 1 << (ALARM_SHIFT + motor)
    assert wrong & ALARM_BITS


def test_without_inputs_nothing_is_claimed_or_read() -> None:
    gpio = Gpio()
    assert lines(gpio, STEPS.model_copy(update={"alarm_pins": None}), None).read() == 0
    assert gpio.inputs == []


@pytest.mark.parametrize("busy", [26, 17])
def test_a_line_that_another_has_is_named_and_the_chip_given_back(busy: int) -> None:
    gpio = Gpio(busy=(busy,))
    with pytest.raises(PulseFault, match=rf"GPIO .*{busy}.* cannot be claimed \(GPIO busy\)"):
        lines(gpio)
    assert gpio.open == 0


def test_outputs_begin_safe_and_only_the_group_is_written() -> None:
    gpio = Gpio()
    made = lines(gpio)
    assert list(gpio.outputs.values()) == [0, 0, 0, 0, 0, 0, 0]
    assert list(gpio.outputs) == [17, 27, 22, 23, 24, 25, 5]
    made.write(0b101, 0b111)
    made.write(ESTOP_BIT, ESTOP_BIT << 10)
    assert gpio.written == [(0b101, 0b111)]
    made.close()
    assert gpio.open == 0


def test_switched_outputs_are_a_group_of_their_own_that_begins_safe() -> None:
    """A valve that is off at a high level, and a brake that is safe when it is on."""
    gpio = Gpio()
    made = LgpioLines(lgpio_pins(STEPS, InputSettings(), SWITCHES), gpio)
    assert [gpio.outputs[pin] for pin in (12, 16, 18)] == [0, 1, 1]
    made.write(0b101, 0b111)
    assert (gpio.leaders, gpio.written) == ([17], [(0b101, 0b111)])
    made.write(*SWITCHES.levels({"gripper": True, "brake": False}))
    assert (gpio.leaders, gpio.written[1:]) == ([17, 12], [(0b001, 0b101)])


@pytest.mark.parametrize(("active_high", "released"), [(True, 0), (False, 1)])
def test_drives_are_released_by_whoever_is_left(active_high: bool, released: int) -> None:
    """Also where an input cannot be had."""
    gpio = Gpio(busy=(26,))
    steps = StepSettings(enable_active_high=active_high)
    assert release_drives(steps, InputSettings(), gpio=gpio) == "STEP low, drives released"
    assert gpio.outputs[5] == released
    assert [gpio.outputs[pin] for pin in (17, 27, 22)] == [0, 0, 0]
    assert gpio.open == 0
    held = Gpio()
    assert "ENA left" in release_drives(steps, InputSettings(), hold=True, gpio=held)
    assert 5 not in held.outputs
    assert np.log2(ENABLE_BIT) == 6
