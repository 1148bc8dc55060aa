"""Three VL53L1X on one bus: started through XSHUT, read at their rate, restarted one by one."""

from __future__ import annotations

import errno
import os
import threading
from collections import deque
from collections.abc import Callable, Sequence

from smbus2 import i2c_msg

from deltactl.drivers.i2c import TRANSIENT_ERRNOS, I2cBus, Registers
from deltactl.drivers.ranging.contract import Reading
from deltactl.drivers.ranging.registers import DEFAULT_ADDRESS, RESULT_BLOCK
from deltactl.drivers.ranging.slot import (
    RESET_HOLD_NS,
    Place,
    Slot,
    SlotState,
    XshutLine,
    somebody_at_default,
)
from deltactl.drivers.settings import RangingSettings
from deltactl.foundation.clock import NS_PER_S, Clock, ns
from deltactl.foundation.errors import BusDead, HardwareError, SensorFault

SILENCE_LIMIT_NS = ns(0.6)
"""Longer than a sensor may take to boot (0.5 s): one that boots slowly does not look like this."""
NOBODY_THERE_LIMIT_NS = ns(2.0)
"""At a start each of three sensors may have been waited for in turn, on a bus that is well."""
SILENCE_TRANSFERS = 10
"""So many transfers must have failed as well: nobody asked is not nobody answered."""

RESULT_READ_BITS = 21 * 9
"""Bits on the wire of one 17-byte result read: 4 bytes to say from where, 17 of data."""
TIMED_READS = 50
SLOWEST_NS = 2**62
SLOW_READ_NS = 1_200_000
"""A read takes 0.48 ms at 400 kHz and 1.9 ms at 100 kHz; scheduling adds, so the fastest counts."""


class BusWatch:
    """An I2cBus around a bus, noting what succeeds."""

    def __init__(self, bus: I2cBus, clock: Clock):
        self._bus = bus
        self._clock = clock
        self._silent_since_ns: int | None = None
        self._failures = 0
        self._last_errno = 0
        self._reads, self._fastest_read_ns = 0, SLOWEST_NS

    def i2c_rdwr(self, *i2c_msgs: i2c_msg) -> None:
        """Pass on. Raises BusDead when the adapter itself is gone."""
        start_ns = self._clock.now_ns()
        try:
            self._bus.i2c_rdwr(*i2c_msgs)
        except OSError as error:
            if error.errno not in TRANSIENT_ERRNOS:
                raise BusDead(
                    f"the I2C adapter fails ({error.strerror}): check that the bus is still"
                    " there (ls /dev/i2c-*) and restart"
                ) from error
            self._failures += 1
            self._last_errno = error.errno or 0
            if self._silent_since_ns is None:
                self._silent_since_ns = start_ns
            raise
        self._silent_since_ns = None
        self._failures = 0
        if self._reads < TIMED_READS and len(i2c_msgs[-1]) == RESULT_BLOCK.size:
            self._time_read(self._clock.now_ns() - start_ns)

    def close(self) -> None:
        """Close the bus."""
        self._bus.close()

    def reset(self) -> None:
        """Forget earlier silence."""
        self._silent_since_ns = None
        self._failures = 0

    def check_alive(self, starting: bool) -> None:
        """Raises BusDead when nobody has answered for 0.6 s (`starting` with NACKs only: 2 s)."""
        if self._silent_since_ns is None or self._failures < SILENCE_TRANSFERS:
            return
        patient = starting and self._last_errno == errno.EREMOTEIO
        silent_ns = self._clock.now_ns() - self._silent_since_ns
        if silent_ns > (NOBODY_THERE_LIMIT_NS if patient else SILENCE_LIMIT_NS):
            raise BusDead(
                f"no sensor answers on the I2C bus for {silent_ns / NS_PER_S:.1f} s"
                f" (errno {self._last_errno}, {os.strerror(self._last_errno)}): check the"
                " sensors' supply, SDA and SCL, their pull-ups and the XSHUT wires"
            )

    def measured_slow(self) -> float | None:
        """Clock [Hz] that the fastest of the first reads suggests, if well below 400 kHz."""
        if self._reads < TIMED_READS or self._fastest_read_ns < SLOW_READ_NS:
            return None
        return RESULT_READ_BITS * NS_PER_S / self._fastest_read_ns

    def _time_read(self, took_ns: int) -> None:
        self._reads += 1
        self._fastest_read_ns = min(took_ns, self._fastest_read_ns)


AXES = ("x", "y", "z")
EVENTS_KEPT = 100
RATE_TOLERANCE = 0.1


class SensorBank:
    """The RangingSensors of a robot. Every method may be called from any thread.

    A restart goes on in short steps, one a poll, while the other sensors are read as always.
    """

    def __init__(
        self,
        settings: RangingSettings,
        bus: I2cBus,
        lines: Sequence[XshutLine],
        clock: Clock,
        on_close: Sequence[Callable[[], None]] = (),
    ):
        """`lines` in the order x, y, z; `on_close` is called at the end of `close`."""
        self._settings = settings
        self._clock = clock
        self._bus = BusWatch(bus, clock)
        self._on_close = tuple(on_close)
        self._lock = threading.RLock()
        self._epoch_ns = 0
        self._events: deque[str] = deque(maxlen=EVENTS_KEPT)
        self._advised: set[str] = set()
        places = [
            Place(axis, index, settings.addresses[index], settings.xshut_pins[index])
            for index, axis in enumerate(AXES)
        ]
        self._slots = [
            Slot(place, line, self._bus, clock, settings, self._start_at_ns)
            for place, line in zip(places, lines, strict=True)
        ]

    def start(self) -> None:
        """Pulse all XSHUT, address, configure and start all three, staggered over a period.

        Sensors keep their addresses when a daemon restarts, so they are always reset. Raises
        BusDead when nobody answers, SensorFault naming the sensor that does not come up;
        then all three are held in reset.
        """
        with self._lock:
            self._advised.clear()
            self._bus.reset()
            try:
                self._hold_all()
                while not all(slot.state is SlotState.RANGING for slot in self._slots):
                    self._advance()
                    self._check(starting=True)
                    self._sleep_to_next_step()
            except HardwareError:
                self._shut_down()
                raise
            self._bus.reset()

    def poll(self) -> list[Reading]:
        """New samples of the sensors that range, and one step of those that restart.

        Raises BusDead while nobody has answered for 0.6 s, and SensorFault from then on until
        the next `start` when three restarts did not bring a sensor back.
        """
        with self._lock:
            self._advance()
            readings = []
            for slot in self._slots:
                if slot.state is SlotState.RANGING:
                    reading = self._read(slot)
                    if reading is not None:
                        readings.append(reading)
            self._check(starting=False)
            self._advise()
            return readings

    def health(self) -> dict[str, str]:
        """Per axis 'ok', 'off', 'starting', 'restarting (why)', or what is wrong."""
        return {slot.place.axis: slot.health() for slot in self._slots}

    def take_events(self) -> list[str]:
        """What happened since the last call: restarts, brown-outs, advice; one line each."""
        with self._lock:
            events = list(self._events)
            self._events.clear()
        return events

    def measured_hz(self) -> dict[str, float | None]:
        """Samples per second of each sensor over the last seconds; None while not yet known."""
        return {slot.place.axis: slot.reader.measured_hz for slot in self._slots}

    def close(self) -> None:
        """Stop ranging, hold the sensors in reset, and give back what came with `on_close`."""
        with self._lock:
            self._shut_down()
            for give_back in self._on_close:
                give_back()

    def _hold_all(self) -> None:
        for slot in self._slots:
            slot.renew()
        self._clock.sleep_until_ns(self._clock.now_ns() + RESET_HOLD_NS)
        for address in (DEFAULT_ADDRESS, *self._settings.addresses):
            if Registers(self._bus, self._clock, address, 0).answers():
                pins = ", ".join(str(pin) for pin in self._settings.xshut_pins)
                raise SensorFault(
                    f"somebody answers at 0x{address:02X} with all three sensors held in reset:"
                    f" check the XSHUT wires (GPIO {pins}), or move the other device away"
                )
        self._epoch_ns = self._clock.now_ns()

    def _advance(self) -> None:
        """Give the turn at 0x29 to the next sensor, and let each take a step."""
        held = [slot for slot in self._slots if slot.state is SlotState.HELD]
        if held and not self._somebody_addressing():
            min(held, key=lambda slot: slot.attempts).begin()
        for slot in self._slots:
            was = slot.state
            failure = slot.step()
            if failure is not None:
                self._restart(slot, failure)
            elif slot.state is SlotState.RANGING is not was:
                self._events.append(f"{slot.place} ranges")

    def _sleep_to_next_step(self) -> None:
        pending = [slot.wake_ns for slot in self._slots if slot.is_stepping]
        if pending:
            self._clock.sleep_until_ns(min(pending))

    def _read(self, slot: Slot) -> Reading | None:
        reading = None
        try:
            reading = slot.reader.read()
        except HardwareError:
            raise
        except OSError as error:
            slot.reader.failed(error)
            if error.errno == errno.EREMOTEIO and self._browned_out():
                self._restart(slot, f"brown-out: it answers at 0x{DEFAULT_ADDRESS:02X}")
                return None
        why = slot.reader.why_restart()
        if why is not None:
            self._restart(slot, why)
        return reading

    def _browned_out(self) -> bool:
        return not self._somebody_addressing() and somebody_at_default(self._bus, self._clock)

    def _somebody_addressing(self) -> bool:
        return any(slot.state is SlotState.ADDRESSING for slot in self._slots)

    def _restart(self, slot: Slot, why: str) -> None:
        slot.restart(why)
        self._events.append(f"{slot.place} held in reset: {why}")

    def _check(self, starting: bool) -> None:
        # A start does not read the sensors that already range: they prove the bus in their way.
        if not (starting and any(slot.state is SlotState.RANGING for slot in self._slots)):
            self._bus.check_alive(starting)
        for slot in self._slots:
            if slot.fault is not None:
                raise SensorFault(slot.fault)

    def _start_at_ns(self, index: int) -> int:
        """The next instant in a sensor's own third of the period: they must not light together."""
        period_ns = round(NS_PER_S / self._settings.rate_hz)
        now_ns = self._clock.now_ns()
        phase_ns = self._epoch_ns + index * period_ns // len(AXES) - now_ns
        return now_ns + phase_ns % period_ns

    def _advise(self) -> None:
        slow_hz = self._bus.measured_slow()
        if slow_hz is not None:
            self._advise_once(
                "bus",
                f"the I2C bus seems to run at {slow_hz / 1e3:.0f} kHz: set"
                " dtparam=i2c_arm_baudrate=400000 in config.txt and restart",
            )
        wanted_hz = self._settings.rate_hz
        for slot in self._slots:
            found_hz = slot.reader.measured_hz
            if found_hz is not None and abs(found_hz / wanted_hz - 1.0) > RATE_TOLERANCE:
                self._advise_once(
                    slot.place.axis,
                    f"{slot.place} ranges {found_hz:.1f} times a second instead of"
                    f" {wanted_hz:g}: a shorter ranging.timing_budget_ms or lower rate_hz helps",
                )

    def _advise_once(self, subject: str, text: str) -> None:
        if subject not in self._advised:
            self._advised.add(subject)
            self._events.append(text)

    def _shut_down(self) -> None:
        for slot in self._slots:
            slot.shut_down()
