"""Watches a bus in use: is anybody still answering, and does it run at its 400 kHz?"""

from __future__ import annotations

import errno
import os

from smbus2 import i2c_msg

from deltactl.drivers.i2c import TRANSIENT_ERRNOS, I2cBus
from deltactl.drivers.ranging.registers import RESULT_BLOCK
from deltactl.foundation.clock import NS_PER_S, Clock, ns
from deltactl.foundation.errors import BusDead

SILENCE_LIMIT_NS = ns(0.6)
"""Longer than a sensor may take to boot (0.5 s): one that boots slowly does not look like this."""
NOBODY_THERE_LIMIT_NS = ns(2.0)
"""At a start each of three sensors may have been waited for in turn, on a bus that is well."""
SILENCE_TRANSFERS = 10
"""So many transfers must have failed as well: nobody asked is not nobody answered."""

RESULT_READ_BITS = 21 * 9
"""Bits on the wire of one 17-byte result read: 4 bytes to say from where, 17 of data."""
TIMED_READS = 50
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
        self._reads = 0
        self._fastest_read_ns: int | None = None

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
        fastest_ns = self._fastest_read_ns
        if self._reads < TIMED_READS or fastest_ns is None or fastest_ns < SLOW_READ_NS:
            return None
        return RESULT_READ_BITS * NS_PER_S / fastest_ns

    def _time_read(self, took_ns: int) -> None:
        self._reads += 1
        if self._fastest_read_ns is None or took_ns < self._fastest_read_ns:
            self._fastest_read_ns = took_ns
