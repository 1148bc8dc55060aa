"""One of the three sensors in its place: its line, address and pin, and what it is doing.

The generators that bring it from reset to ranging serve the blocking start and the restart of one
sensor in the middle of a run, where each poll takes one short step.
"""

from __future__ import annotations

import contextlib
import enum
from collections.abc import Callable
from typing import NamedTuple, Protocol

from deltactl.drivers.i2c import I2cBus, Registers
from deltactl.drivers.ranging.registers import DEFAULT_ADDRESS, RangeTiming
from deltactl.drivers.ranging.sample_reader import SampleReader
from deltactl.drivers.ranging.vl53l1x import BOOT_NS, Vl53l1x
from deltactl.drivers.settings import RangingSettings
from deltactl.foundation.clock import NS_PER_S, Clock, Task, ns
from deltactl.foundation.errors import HardwareError, SensorFault

RESET_HOLD_NS = ns(0.005)
SILENCE_TIMEOUT_NS = ns(0.5)
SILENCE_STEP_NS = ns(0.01)


def somebody_at_default(bus: I2cBus, clock: Clock) -> bool:
    """Whether a sensor answers at 0x29: it is fresh out of a reset (brown-out)."""
    return Registers(bus, clock, DEFAULT_ADDRESS, 0).answers()


def take_address(sensor: Vl53l1x, line: XshutLine, address: int, bus: I2cBus, clock: Clock) -> Task:
    """XSHUT pulse, boot, identity, new address. Nobody else may be at 0x29 meanwhile.

    Raises SensorFault when it does not boot, is something else, or ignores its XSHUT.
    """
    line.off()
    sensor.was_reset()
    yield clock.now_ns() + RESET_HOLD_NS
    give_up_ns = clock.now_ns() + SILENCE_TIMEOUT_NS
    # Another sensor that browned out answers there too, until its own restart holds it in reset.
    while somebody_at_default(bus, clock):
        if clock.now_ns() >= give_up_ns:
            raise SensorFault(
                f"is held in reset but somebody answers at 0x{DEFAULT_ADDRESS:02X}"
                " (is the XSHUT wire connected?)"
            )
        yield clock.now_ns() + SILENCE_STEP_NS
    line.on()
    yield clock.now_ns() + BOOT_NS
    yield from sensor.wait_booted()
    sensor.check_identity()
    sensor.change_address(address)


def configure(
    sensor: Vl53l1x,
    settings: RangingSettings,
    clock: Clock,
    on_timing: Callable[[RangeTiming], None],
    start_at_ns: Callable[[], int],
) -> Task:
    """Default settings, VHV, mode, budget and period; then start at the instant asked for.

    Raises SensorFault when the chip makes no first sample or lacks its calibration.
    """
    sensor.write_defaults(settings.io_2v8)
    yield clock.now_ns()
    yield from sensor.calibrate_vhv()
    yield clock.now_ns()
    timing = sensor.set_mode(settings.mode, settings.timing_budget_ms)
    sensor.set_inter_measurement(round(NS_PER_S / settings.rate_hz))
    on_timing(timing)
    yield start_at_ns()
    sensor.start()


RESTART_LIMIT = 3
"""So many attempts to bring a sensor up, then it is a fault."""
SETTLED_NS = ns(5.0)
"""A sensor that has ranged for so long has its attempts back."""


class XshutLine(Protocol):
    """Drives one XSHUT: low holds a sensor in reset, released lets it boot.

    A gpiozero `DigitalOutputDevice` is one; `OpenDrainLine` is the safe way on a robot.
    """

    def off(self) -> None:
        """Hold the sensor in reset."""

    def on(self) -> None:
        """Let the sensor boot."""

    def close(self) -> None:
        """Give the pin back."""


class SlotState(enum.Enum):
    """What a sensor is doing. HELD: in reset, waiting for its turn at 0x29."""

    OFF = "off"
    HELD = "held"
    ADDRESSING = "addressing"
    CONFIGURING = "configuring"
    RANGING = "ranging"
    FAILED = "failed"


class Place(NamedTuple):
    """Where a sensor sits: axis, number on the bus, address and XSHUT pin (BCM)."""

    axis: str
    number: int
    address: int
    pin: int

    def __str__(self) -> str:
        return f"sensor {self.axis} (address 0x{self.address:02X}, XSHUT on GPIO {self.pin})"


class Slot:
    """Brings one sensor up in short steps, and gives up after three attempts."""

    def __init__(
        self,
        place: Place,
        line: XshutLine,
        bus: I2cBus,
        clock: Clock,
        settings: RangingSettings,
        start_at_ns: Callable[[int], int],
    ):
        self.place = place
        self.state = SlotState.OFF
        self.wake_ns = 0
        self._line = line
        self._bus = bus
        self._clock = clock
        self._settings = settings
        self._start_at_ns = start_at_ns
        self._sensor = Vl53l1x(bus, clock, settings.retries)
        self.reader = SampleReader(
            place.axis, settings.offsets_mm[place.number], self._sensor, clock, settings
        )
        self._task: Task | None = None
        self.attempts = 0
        """How often it was begun since it last ranged well."""
        self._reason = ""

    @property
    def is_stepping(self) -> bool:
        """Whether it is being brought up; `wake_ns` is then its next step."""
        return self._task is not None

    @property
    def fault(self) -> str | None:
        """What is wrong, once it has failed for good."""
        return self._reason if self.state is SlotState.FAILED else None

    def health(self) -> str:
        """'ok', 'off', 'starting', 'restarting (why)', or what is wrong."""
        if self.state is SlotState.RANGING:
            return self.reader.trouble or "ok"
        if self.state is SlotState.OFF:
            return "off"
        if self.state is SlotState.FAILED:
            return self._reason
        return f"restarting ({self._reason})" if self._reason else "starting"

    def renew(self) -> None:
        """Forget earlier failures and hold in reset, before a start."""
        self.attempts = 0
        self._hold("")

    def restart(self, why: str) -> None:
        """Hold in reset until `begin`; it has failed if its attempts are used up."""
        if self.state is SlotState.RANGING and self.reader.ranged_ns > SETTLED_NS:
            self.attempts = 0
        self._hold(why)
        if self.attempts >= RESTART_LIMIT:
            self.state = SlotState.FAILED
            self._reason = (
                f"{self.place}: {why}; tried {self.attempts} times, check its supply and wires"
            )

    def begin(self) -> None:
        """Start bringing it up; only one sensor at a time may be at 0x29."""
        self.attempts += 1
        self.state = SlotState.ADDRESSING
        self._task = take_address(
            self._sensor, self._line, self.place.address, self._bus, self._clock
        )
        self.wake_ns = self._clock.now_ns()

    def step(self) -> str | None:
        """One step of bringing it up, when due; returns what went wrong. Raises only BusDead."""
        if self._task is None or self._clock.now_ns() < self.wake_ns:
            return None
        try:
            self.wake_ns = next(self._task)
        except StopIteration:
            self._step_done()
        except SensorFault as error:
            return str(error)
        except HardwareError:
            raise
        except OSError as error:
            return (
                f"no answer at 0x{self._sensor.address:02X} while it is set up"
                f" (errno {error.errno}, {error.strerror})"
            )
        return None

    def shut_down(self) -> None:
        """Stop ranging if it can be reached, and hold in reset."""
        if self.state is SlotState.RANGING:
            with contextlib.suppress(OSError):  # reset stops it too
                self._sensor.stop()
        self._hold("")
        self.state = SlotState.OFF

    def _hold(self, reason: str) -> None:
        self._line.off()
        if self._task is not None:
            self._task.close()
            self._task = None
        self.state, self._reason = SlotState.HELD, reason

    def _step_done(self) -> None:
        if self.state is SlotState.CONFIGURING:
            self._task = None
            self.state = SlotState.RANGING
            self.reader.started()
            return
        self.state = SlotState.CONFIGURING
        self._task = configure(
            self._sensor,
            self._settings,
            self._clock,
            self.reader.set_timing,
            lambda: self._start_at_ns(self.place.number),
        )
