"""A servo robot behind the contract of a step output: set-points go in, arms follow them.

To the planner, the queue and the controller a servo is a stepper with fine steps. A tick is a
set-point passed; counts are where the reference is. What differs: a stop takes the current away
and puts the brakes on, so a stopped servo is not energised.
"""

from __future__ import annotations

import threading
from collections.abc import Callable

import numpy as np

from deltactl.drivers.current_drives import CurrentDrives
from deltactl.drivers.steps.contract import Counts, OutputState, OutputStatus, Ticks
from deltactl.firmware_py.servo.loop import BLOCK_NS, ServoLoop, ServoSample
from deltactl.foundation.clock import Clock, Task, sleep_s
from deltactl.foundation.errors import EmergencyStop, HardwareError, NotReady, PulseFault
from deltactl.models.servo_drive import ServoDrive

CAPACITY = 1_000_000
"""Ticks that may wait; a tenth of a second of motion is at most some ten thousand."""
SETTLE_S = 0.2
"""From lifted brakes to the first set-point: the observer learns what gravity and friction take."""
MOST_BEHIND_NS = 500_000_000
"""Time that a loop which was held up does not make up for: the simulated robot stood still."""


class ServoOutput:
    """Implements `deltactl.drivers.steps.contract.StepOutput` on current-commanded drives."""

    def __init__(
        self,
        drive: ServoDrive,
        drives: CurrentDrives,
        clock: Clock,
        heartbeat_ns: int,
        estop_pressed: Callable[[], bool],
        on_block: Callable[[int], None] = lambda t_ns: None,
    ):
        """`on_block` gets the time up to which the loop has run."""
        self._drive, self._drives, self._clock = drive, drives, clock
        self._heartbeat_ns = heartbeat_ns
        self._estop_pressed = estop_pressed
        self._on_block = on_block
        self._lock = threading.RLock()
        self._state, self._reason = OutputState.DISABLED, ""
        self._slip_ns = self._late_ns = 0
        self._closed = False
        self._beat_ns = clock.now_ns()
        self._loop = ServoLoop(drive, drives, clock.now_ns())
        self._task = clock.start("servo", self._run())

    @property
    def minimum_period_ns(self) -> int:
        """Any distance will do."""
        return 1

    def enable(self) -> None:
        """See StepOutput: lifts the brakes and holds the arms where they are."""
        with self._lock:
            if self._closed:
                raise PulseFault(
                    "cannot energise the drives: closed; start the servo output again and home"
                )
            self._refuse_when_pressed("energise the drives")
            if self._state is OutputState.STOPPED:
                raise NotReady(
                    f"cannot energise the drives: stopped ({self._reason}); acknowledge it first"
                )
            if self._state is not OutputState.DISABLED:
                return
            self._drives.enable()
            self._loop.settle()
            self._state = OutputState.READY
        sleep_s(self._clock, SETTLE_S)

    def disable(self) -> None:
        with self._lock:
            self._release()
            if self._state is not OutputState.STOPPED:
                self._state = OutputState.DISABLED

    def push(self, ticks: Ticks) -> None:
        now_ns = self._clock.now_ns()
        with self._lock:
            if self._state is OutputState.STOPPED:
                raise NotReady(
                    f"cannot queue set-points: stopped ({self._reason}); acknowledge the stop first"
                )
            if self._state is OutputState.DISABLED:
                raise NotReady("cannot queue set-points: the drives are not enabled; enable them")
            if not len(ticks):
                return
            room = self.room()
            if len(ticks) > room:
                raise PulseFault(
                    f"{len(ticks)} set-points do not fit, there is room for {room}; wait"
                )
            if np.any(np.diff(ticks.due_ns) <= 0):
                raise ValueError("set-points must be strictly increasing in time")
            if np.abs(ticks.steps).max() > 1:
                raise ValueError("a set-point's steps must be -1, 0 or +1")
            setpoints = self._loop.setpoints
            if not len(setpoints):
                self._late_ns = max(0, now_ns - int(ticks.due_ns[0]))
                self._slip_ns += self._late_ns
            self._beat_ns = max(self._beat_ns, now_ns)
            setpoints.push(Ticks(ticks.due_ns + self._late_ns, ticks.steps), now_ns)
            self._state = OutputState.MOVING

    def room(self) -> int:
        with self._lock:
            return CAPACITY - len(self._loop.setpoints)

    def status(self) -> OutputStatus:
        with self._lock:
            setpoints = self._loop.setpoints
            return OutputStatus(
                self._state,
                setpoints.counts,
                len(setpoints),
                self._slip_ns,
                self._reason,
                self._state in (OutputState.READY, OutputState.MOVING),
            )

    def take_sent(self) -> Ticks:
        with self._lock:
            return self._loop.setpoints.take_sent()

    def take_samples(self) -> list[ServoSample]:
        """References, angles, currents and disturbances since the last call."""
        with self._lock:
            return self._loop.take_samples()

    def set_counts(self, counts: Counts) -> None:
        """See StepOutput: the encoders are set to where the counts say."""
        with self._lock:
            if self._state is OutputState.MOVING:
                raise NotReady("cannot set the counters: the motors are moving; wait or stop")
            ratio = self._drive.rad_per_step / self._drive.rad_per_count
            first, second, third = (round(count * ratio) for count in counts)
            self._drives.set_counts((first, second, third))
            self._loop.setpoints.restart(counts, self._clock.now_ns())
            self._loop.settle()

    def switch(self, levels: int, mask: int) -> None:
        """See StepOutput: servo robots are simulated only, and have no outputs yet."""
        raise NotReady("cannot switch an output: a robot with servo drives has none")

    def stop(self, reason: str) -> None:
        """See StepOutput: currents to zero, brakes on."""
        with self._lock:
            self._release()
            if self._state is not OutputState.STOPPED:
                self._state, self._reason = OutputState.STOPPED, reason or "stop requested"

    def acknowledge(self) -> None:
        with self._lock:
            if self._state is not OutputState.STOPPED:
                return
            self._refuse_when_pressed("release the stop")
            self._drives.clear()
            self._state, self._reason = OutputState.DISABLED, ""

    def beat(self) -> None:
        self._beat_ns = self._clock.now_ns()

    def close(self) -> None:
        self.stop("closed")
        self._task.stop()
        with self._lock:
            self._closed = True
            self._drives.close()

    def _run(self) -> Task:
        while True:
            with self._lock:
                self._block(self._clock.now_ns())
            yield self._clock.now_ns() + BLOCK_NS

    def _block(self, now_ns: int) -> None:
        loop = self._loop
        loop.due_ns = max(loop.due_ns, now_ns - MOST_BEHIND_NS)
        if self._state is not OutputState.STOPPED and self._estop_pressed():
            self.stop("e-stop")
        if self._state in (OutputState.READY, OutputState.MOVING):
            self._move(now_ns)
        loop.idle(now_ns)
        self._on_block(now_ns)

    def _move(self, now_ns: int) -> None:
        loop, last_ns = self._loop, now_ns
        silent = self._state is OutputState.MOVING and now_ns - self._beat_ns > self._heartbeat_ns
        if silent:
            last_ns = self._beat_ns + self._heartbeat_ns
        try:
            wrong = loop.run(last_ns)
        except (HardwareError, ValueError) as error:
            wrong = str(error)
        if wrong or silent:
            self.stop(wrong or "no heartbeat")
        elif self._state is OutputState.MOVING and not len(loop.setpoints):
            self._state = OutputState.READY

    def _release(self) -> None:
        """No current, brakes on, nothing queued."""
        self._drives.make_safe()
        setpoints = self._loop.setpoints
        setpoints.restart(setpoints.counts, self._clock.now_ns())

    def _refuse_when_pressed(self, what: str) -> None:
        if self._estop_pressed():
            raise EmergencyStop(
                f"cannot {what}: the e-stop is pressed or its wire is open; release the button"
            )
