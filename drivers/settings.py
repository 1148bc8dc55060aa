"""Settings of the drivers: pins, addresses, timing. Sections of a robot file."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from deltactl.foundation.strict_yaml import RuledModel, StrictModel, rule

Pin = Annotated[int, Field(ge=0, le=27, description="BCM numbers of the 40-pin header")]
PinPerMotor = tuple[Pin, Pin, Pin]
Offset = Annotated[float, Field(ge=-4000.0, le=4000.0, description="a VL53L1X sees 4 m")]
Address = Annotated[int, Field(ge=0x08, le=0x77, description="the 7-bit addresses I2C lets us use")]


SHORTEST_PERIOD_S = {
    "pulse": 50e-6,  # what a Python process of its own keeps up with on a Pi
    "gpiozero": 2e-3,  # below this, pulses of a thread among others are late more often than not
}


Name = Annotated[
    str,
    Field(
        pattern=r"^[a-z][a-z0-9_]{0,30}$",
        description="small letters, figures and _, a letter first",
    ),
]


class StepSettings(StrictModel):
    """How steps get out: backend, pins, the drive's timing (CL57T: pulse >= 1 us, DIR set-up)."""

    backend: Literal["pulse", "gpiozero"] = "pulse"
    """`pulse`: a process of its own sends the pulses; `gpiozero`: a thread, for 2 ms and more."""
    step_pins: PinPerMotor = (17, 27, 22)
    """STEP (PUL) of motors 1, 2, 3."""
    direction_pins: PinPerMotor = (23, 24, 25)
    """DIR of motors 1, 2, 3."""
    enable_pin: Pin | None = 5
    """ENA of all drives; null: they are not switched off."""
    alarm_pins: PinPerMotor | None = (6, 13, 19)
    """ALM of drives 1, 2, 3; null: nobody looks at them."""
    inverted: tuple[bool, bool, bool] = (False, False, False)
    """Which motors turn the other way round."""
    enable_active_high: bool = True
    """Level of ENA with which the drives hold."""
    alarm_active_high: bool = False
    """Level of ALM that is an alarm."""
    pulse_width_us: Annotated[
        float, Field(ge=1.0, le=1000.0, description="CL57T sees 1 us; longer than 1 ms is no pulse")
    ] = 5.0
    direction_setup_us: Annotated[
        float, Field(ge=0.0, le=1000.0, description="DIR must be set before STEP; 1 ms is ample")
    ] = 5.0
    minimum_gap_fraction: Annotated[
        float, Field(ge=0.5, le=1.0, description="under half the period a motor loses steps")
    ] = 0.9
    """No two steps closer than this part of the planned distance, whatever happened before."""
    heartbeat_s: Annotated[
        float, Field(ge=0.01, le=5.0, description="how long pulses outlive a dead controller")
    ] = 0.25
    chip: Annotated[int, Field(ge=0, le=9, description="/dev/gpiochip0 to 9")] | None = None
    """Which GPIO chip all pins are on; null: the one behind the 40-pin header, by its label."""

    @property
    def shortest_period_s(self) -> float:
        """Shortest time between two ticks, whatever motors step at them."""
        return SHORTEST_PERIOD_S[self.backend]

    @property
    def tick_s(self) -> float:
        """Shortest time between two ticks of motors that step in their own time."""
        return max(self.shortest_period_s, self.pulse_cycle_s)

    @property
    def pulse_cycle_s(self) -> float:
        """What a pulse, the pause after it and the set-up of DIR take."""
        return (2.0 * self.pulse_width_us + self.direction_setup_us) * 1e-6


class SwitchedPin(StrictModel):
    """An output that jobs switch: a gripper, a valve, a pump. On, off and safe are the tool's."""

    pin: Pin
    """Where it is connected."""
    active_high: bool = True
    """Level of the pin while it is on."""
    safe: bool
    """What it is put to by every kind of stop, with the drives off, and while nothing runs it."""

    def level(self, on: bool) -> bool:
        """What a meter would show."""
        return on == self.active_high


class NamedInput(StrictModel):
    """An input that jobs wait for; it has the Pi's pull-up, a switch pulls it to ground."""

    pin: Pin
    """Where it is connected."""
    active_high: bool = False
    """Level of the pin while it is on."""


class InputSettings(StrictModel):
    """The e-stop input: normally closed to ground, so that a broken wire stops the robot; and
    what jobs wait for."""

    estop_pin: Pin | None = 26
    """null: there is no such input."""
    estop_active_high: bool = True
    """Level of the input that stops."""
    named: Annotated[
        dict[Name, NamedInput], Field(max_length=16, description="a Pi has not many pins more")
    ] = Field(default_factory=dict)
    """What jobs may wait for, by name: `part_there: {pin: 12}`."""


class RangingSettings(RuledModel):
    """The three VL53L1X: bus, addresses, XSHUT pins, mode and what a good reading is."""

    bus: Annotated[int, Field(ge=0, le=22, description="/dev/i2c-0 to 22; a Pi has no more")] = 1
    addresses: tuple[Address, Address, Address] = (0x30, 0x31, 0x32)
    """What the sensors for x, y and z are called once they are up."""
    xshut_pins: PinPerMotor = (4, 20, 21)
    """XSHUT of the sensors for x, y and z."""
    mode: Literal["short", "long"] = "short"
    """`short` sees 1.3 m and bears daylight, `long` sees 4 m in the dark."""
    timing_budget_ms: Literal[15, 20, 33, 50, 100, 200, 500] = 20
    """How long one reading is measured: the longer, the less noise."""
    rate_hz: Annotated[
        float, Field(gt=0.0, le=60.0, description="a VL53L1X ranges at most some 60 times a second")
    ] = 50.0
    offsets_mm: tuple[Offset, Offset, Offset] = (0.0, 0.0, 0.0)
    """Calibration: what is added to each distance (`deltactl status sensors --calibrate`)."""
    minimum_signal_mcps: Annotated[float, Field(ge=0.0, description="a photon rate")] = 0.5
    maximum_sigma_mm: Annotated[float, Field(gt=0.0, description="no reading has none")] = 30.0
    maximum_jump_mm: Annotated[
        float, Field(gt=0.0, description="with 0 every moving reading is refused")
    ] = 100.0
    maximum_age_s: Annotated[
        float, Field(gt=0.0, description="with 0 every reading is too old")
    ] = 0.2
    retries: Annotated[int, Field(ge=0, le=10, description="more take longer than a reading")] = 3
    io_2v8: bool = True
    """Boards pull I2C up to 2.8 V or more; false only for a bare module on 1.8 V."""

    @rule("mode", "timing_budget_ms")
    def _there_in_that_mode(self) -> None:
        if self.mode == "long" and self.timing_budget_ms == 15:
            raise ValueError("a timing budget of 15 ms exists in short mode only")

    @rule("addresses")
    def _told_apart(self) -> None:
        if len(set(self.addresses)) < 3 or 0x29 in self.addresses:
            raise ValueError(
                "addresses must differ and none may be 0x29, where a rebooted sensor appears"
            )

    @rule("timing_budget_ms", "rate_hz")
    def _fits_into_a_period(self) -> None:
        if self.timing_budget_ms * self.rate_hz > 1000.0:
            raise ValueError("timing_budget_ms does not fit into one period of rate_hz")
