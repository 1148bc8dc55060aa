"""Step outputs on the hardware, from settings (those of the fake bench: drivers.fakes.bench)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from deltactl.drivers.settings import SHORTEST_PERIOD_S, InputSettings, StepSettings
from deltactl.drivers.steps.contract import StepOutput
from deltactl.drivers.steps.gpiozero_pins import GpiozeroLines
from deltactl.drivers.steps.hosts import ProcessStepOutput, PulseProcess, TaskStepOutput
from deltactl.drivers.steps.lgpio_pins import LgpioLines, LgpioPins, lgpio_pin_factory
from deltactl.drivers.steps.lines import (
    ALARM_BITS,
    ENABLE_BIT,
    ESTOP_BIT,
    NO_SWITCHES,
    SWITCH_SHIFT,
    Switches,
)
from deltactl.drivers.steps.player import PlayerSettings
from deltactl.foundation.clock import Clock, VirtualClock, ns

SIGNALS_BEFORE_ENA = 6
"""STEP 1 to 3 and DIR 1 to 3, see drivers/steps/lines.py."""
LGPIO = "deltactl.drivers.steps.lgpio_pins:of_config"
"""What opens the lines in the pulse process, see pulse_main.open_lines."""
POLL_NS = 2_000_000
"""Between edges that are far apart; before each edge there is a look of its own."""
VIRTUAL_POLL_NS = 10_000_000
"""On a virtual clock nothing happens between tasks, and the last look is right at each edge."""
CHECK_AHEAD_NS = 60_000
"""In the pulse process: longer than one look takes, far shorter than a hand."""


def player_settings(
    settings: StepSettings,
    inputs: InputSettings,
    check_ahead_ns: int = 0,
    poll_ns: int = POLL_NS,
    switches: Switches = NO_SWITCHES,
) -> PlayerSettings:
    """What the player needs of the settings."""
    alarms = ALARM_BITS if settings.alarm_pins is not None else 0
    estop = ESTOP_BIT if inputs.estop_pin is not None else 0
    idle = (0 if settings.alarm_active_high else alarms) | (
        0 if inputs.estop_active_high else estop
    )
    return PlayerSettings(
        pulse_width_ns=round(settings.pulse_width_us * 1000),
        direction_setup_ns=round(settings.direction_setup_us * 1000),
        minimum_gap_fraction=settings.minimum_gap_fraction,
        heartbeat_ns=ns(settings.heartbeat_s),
        inverted=sum(mirrored << motor for motor, mirrored in enumerate(settings.inverted)),
        enable_level=int(settings.enable_active_high),
        input_mask=alarms | estop,
        input_idle=idle,
        poll_ns=poll_ns,
        check_ahead_ns=check_ahead_ns,
        switch_mask=switches.mask,
        switch_safe=switches.safe_levels,
    )


def lgpio_pins(
    settings: StepSettings, inputs: InputSettings, switches: Switches = NO_SWITCHES
) -> LgpioPins:
    """The pins as the pulse process claims them; drives released, outputs safe to begin with."""
    enable = [] if settings.enable_pin is None else [settings.enable_pin]
    return LgpioPins(
        settings.chip,
        [*settings.step_pins, *settings.direction_pins, *enable],
        0 if settings.enable_active_high else ENABLE_BIT,
        inputs.estop_pin,
        list(settings.alarm_pins or ()),
        switches.numbers,
        switches.safe_levels >> SWITCH_SHIFT,
    )


def release_drives(
    settings: StepSettings,
    inputs: InputSettings,
    switches: Switches = NO_SWITCHES,
    *,
    hold: bool = False,
    gpio: Any | None = None,
) -> str:
    """Claim the outputs at their safe levels and let them go; returns what was done.

    For when nobody has them any more: the process that had them must have ended. hold: ENA
    stays as it is. gpio: a substitute for lgpio. Raises PulseFault when a line cannot be had.
    """
    # Inputs are left alone: a line that cannot be read must not keep one from being released.
    pins = lgpio_pins(settings, inputs, switches)._replace(estop=None, alarms=[])
    if hold:
        pins = pins._replace(outputs=pins.outputs[:SIGNALS_BEFORE_ENA])
    LgpioLines(pins, gpio).close()
    safe = ", outputs safe" if switches.pins else ""
    if settings.enable_pin is None:
        return f"STEP low{safe}; there is no ENA line"
    return f"STEP low{safe}, {'ENA left as it was' if hold else 'drives released'}"


def build_step_output(
    settings: StepSettings,
    inputs: InputSettings,
    clock: Clock,
    *,
    switches: Switches = NO_SWITCHES,
    pin_factory: Any | None = None,
    board_path: Path | None = None,
) -> StepOutput:
    """The step output of this Pi, by `settings.backend`.

    pin_factory: for the gpiozero backend; the default is one on the chip of the settings.
    board_path: where the pulse process leaves its counters, see hosts.last_counts.
    Raises PulseFault (process or chip not there), ConfigError (pins).
    """
    if settings.backend == "gpiozero":
        lines = GpiozeroLines(
            settings, inputs, pin_factory or lgpio_pin_factory(settings.chip), switches
        )
        return task_output(settings, inputs, clock, lines, switches)
    pins = lgpio_pins(settings, inputs, switches)
    process = PulseProcess(
        player_settings(settings, inputs, CHECK_AHEAD_NS, switches=switches),
        {"lines": LGPIO, "pins": pins},
        board_path=board_path,
    )
    return ProcessStepOutput(process, clock, minimum_period_ns(settings, clock))


def minimum_period_ns(settings: StepSettings, clock: Clock) -> int:
    """Shortest distance of two ticks: what backend and clock can keep, and what a pulse needs."""
    if isinstance(clock, VirtualClock):
        return ns(max(SHORTEST_PERIOD_S["pulse"], settings.pulse_cycle_s))
    return ns(settings.tick_s)


def task_output(
    settings: StepSettings,
    inputs: InputSettings,
    clock: Clock,
    lines: Any,
    switches: Switches = NO_SWITCHES,
) -> TaskStepOutput:
    """A player in this process, on given lines."""
    period_ns = minimum_period_ns(settings, clock)
    poll_ns = VIRTUAL_POLL_NS if isinstance(clock, VirtualClock) else POLL_NS
    return TaskStepOutput(
        lines,
        player_settings(settings, inputs, poll_ns=poll_ns, switches=switches),
        clock,
        period_ns,
    )
