"""The controller: takes requests, runs the control loop, and stops safely when anything fails.

Three loops run on the clock: control (every 10 ms: heartbeat, feeding, watching), ranging
(`ranging.rate_hz`), and in simulation a note of the truth. A request only changes state
under the lock; nothing that waits holds it, so that a stop always gets through.
"""

from __future__ import annotations

import itertools
import threading
from collections import deque
from pathlib import Path

from drivers.ranging.contract import Reading
from drivers.steps.contract import OutputState, OutputStatus
from firmware_py.controller.active_job import ActiveJob, Phase
from firmware_py.controller.contract import JobResult, Status
from firmware_py.controller.homing import Homer
from firmware_py.controller.job_queue import QueuedJob, prepare
from firmware_py.controller.journal import Journal
from firmware_py.controller.ranging_loop import RangingLoop
from firmware_py.controller.report_status import snapshot
from firmware_py.controller.states import Request, State, require
from firmware_py.machine import Machine
from firmware_py.robot_file import RobotFile
from foundation.clock import NS_PER_S, Task, TaskHandle
from foundation.errors import DeltactlError, HardwareError

CONTROL_PERIOD_NS = 10_000_000
MOVING = frozenset({State.RUNNING, State.PAUSED})
EMERGENCY = ("e-stop", "stop requested")


class Controller:
    """Runs one robot. Implements `firmware_py.controller.contract.RobotController`."""

    def __init__(self, robot: RobotFile, robot_file: Path, machine: Machine, recordings: Path):
        self.robot = robot
        self.machine = machine
        self.clock = machine.clock
        self.state = State.OFF
        self.why = ""
        self.job: ActiveJob | None = None
        self.queue: deque[QueuedJob] = deque()
        self.journal = Journal()
        self.ranging = RangingLoop(
            machine.sensors, self.clock, robot.ranging.rate_hz, self._on_reading
        )
        self._robot_file = robot_file
        self._recordings = recordings
        self._results: dict[int, JobResult] = {}
        self._numbers = itertools.count(1)
        self._lock = threading.RLock()
        self._tasks: list[TaskHandle] = []
        self._loops = 0
        self._homer = Homer(robot, machine, self.ranging)

    def power_on(self) -> None:
        """OFF -> UNHOMED. Raises BusDead, SensorFault, DriveAlarm or EmergencyStop."""
        with self._lock:
            require(Request.ON, self.state, self.why)
        self.machine.sensors.start()
        self.machine.output.enable()
        with self._lock:
            self._enter(State.UNHOMED)
            self._start_loops()

    def power_off(self) -> None:
        """-> OFF; the arms may drop."""
        with self._lock:
            require(Request.OFF, self.state, self.why)
            self._end_loops()
            self.machine.output.disable()
            self._enter(State.OFF)
        self.machine.sensors.close()

    def home(self) -> None:
        """UNHOMED or READY -> READY, blocking. Raises NotReady when the sensors disagree."""
        with self._lock:
            require(Request.HOME, self.state, self.why)
            was_ready = self.state is State.READY
            self._enter(State.UNHOMED, "homing")
        try:
            seen = self._homer.home(return_first=was_ready)
        except BaseException:
            self._enter_if(State.UNHOMED, State.UNHOMED)
            raise
        self._enter_if(State.UNHOMED, State.READY)
        self._note("home", seen)

    def submit(self, job: Path, record: Path | None = None) -> int:
        """Check a job against this robot and queue it; returns its number."""
        with self._lock:
            require(Request.RUN, self.state, self.why)
        number = next(self._numbers)
        queued = prepare(number, job, record, self.robot, self._robot_file, self._recordings)
        with self._lock:
            require(Request.RUN, self.state, self.why)
            self.queue.append(queued)
        return number

    def pause(self) -> None:
        """Decelerate on the path and hold."""
        with self._lock:
            require(Request.PAUSE, self.state, self.why)
            assert self.job is not None
            self.job.pause(self.clock.now_ns())
            self._enter(State.PAUSED)

    def resume(self) -> None:
        """Go on along the path."""
        with self._lock:
            require(Request.RESUME, self.state, self.why)
            assert self.job is not None
            self.job.resume(self.clock.now_ns())
            self._enter(State.RUNNING)

    def cancel(self) -> None:
        """Decelerate on the path; drop the job and the queue."""
        with self._lock:
            require(Request.CANCEL, self.state, self.why)
            assert self.job is not None
            self.job.cancel(self.clock.now_ns())
            for waiting in self.queue:
                self._finish(waiting.number, waiting.name, "cancelled", "the queue was cancelled")
            self.queue.clear()
            self._enter(State.RUNNING)

    def stop(self, reason: str) -> None:
        """Emergency stop; takes no lock before the pulses have ended."""
        self.machine.output.stop(reason)
        with self._lock:
            if self.state is not State.OFF:
                self._halt(State.STOPPED, reason)

    def acknowledge(self) -> None:
        """-> UNHOMED. Raises EmergencyStop or DriveAlarm while the cause is still there."""
        with self._lock:
            require(Request.ACKNOWLEDGE, self.state, self.why)
        self.machine.output.acknowledge()
        self._restart_sensors_if_needed()
        self.machine.output.enable()
        with self._lock:
            self._enter(State.UNHOMED)
            self._start_loops()

    def status(self) -> Status:
        """A snapshot."""
        with self._lock:
            return snapshot(self)

    def result(self, job_id: int) -> JobResult | None:
        """How a job ended; None while it is queued or running."""
        return self._results.get(job_id)

    def progress_count(self) -> int:
        """Grows only while both loops go round (in OFF, STOPPED and FAULT: the control loop)."""
        sensing = self.state not in (State.OFF, State.STOPPED, State.FAULT)
        return min(self._loops, self.ranging.rounds) if sensing else self._loops

    def close(self) -> None:
        """Stop, finish the recording, give the hardware back."""
        with self._lock:
            if self.state in MOVING:
                self._halt(State.STOPPED, "the controller was closed")
            self._end_loops()
        self.machine.close()
        self.journal.close()

    # The loops

    def _start_loops(self) -> None:
        self._end_loops()
        self._tasks = [
            self.clock.start("control", self._control_task(), self._on_loop_error),
            self.clock.start("ranging", self.ranging.task(), self._on_loop_error),
        ]

    def _end_loops(self) -> None:
        for task in self._tasks:
            task.stop()
        self._tasks = []

    def _control_task(self) -> Task:
        while True:
            with self._lock:
                self._control(self.clock.now_ns())
            self._loops += 1
            yield self.clock.now_ns() + CONTROL_PERIOD_NS

    def _control(self, now_ns: int) -> None:
        output = self.machine.output
        output.beat()
        self.journal.sent(output.take_sent())
        seen = output.status()
        if seen.state is OutputState.STOPPED:
            self._on_output_stopped(seen)
        elif self.job is not None:
            self._drive_job(self.job, now_ns)
        elif self.state is State.READY and self.queue:
            self._begin(self.queue.popleft(), now_ns)

    def _begin(self, queued: QueuedJob, now_ns: int) -> None:
        try:
            self.job = ActiveJob(queued, self.robot, self.machine, self.journal)
            self.job.begin(now_ns)
        except DeltactlError as error:
            self.job = None
            self._finish(queued.number, queued.name, "refused", str(error))
            return
        self._enter(State.RUNNING)

    def _drive_job(self, job: ActiveJob, now_ns: int) -> None:
        job.advance(now_ns)
        if job.phase is Phase.ENDED:
            self.job = None
            outcome = "cancelled" if job.cancelled else "done"
            self._finish(job.number, job.name, outcome, "", job.recording, job.recording_error)
            self._enter(State.READY)

    def _on_reading(self, reading: Reading) -> None:
        self.journal.reading(reading)
        if self.machine.world is not None and reading.axis == "x":
            self.journal.truth(self.machine.world.truth(reading.t_ns))

    # What goes wrong

    def _on_output_stopped(self, seen: OutputStatus) -> None:
        if self.state in (State.STOPPED, State.FAULT):
            return
        emergency = any(word in seen.reason for word in EMERGENCY)
        self._halt(State.STOPPED if emergency else State.FAULT, seen.reason)

    def _on_loop_error(self, error: BaseException) -> None:
        """A loop died: stop the pulses first, then say why."""
        self.machine.output.stop(f"fault: {error}")
        with self._lock:
            self._halt(State.FAULT, " ".join(str(error).split()))

    def _halt(self, state: State, why: str) -> None:
        self.journal.sent(self.machine.output.take_sent())
        self._note("stop" if state is State.STOPPED else "fault", why)
        outcome = "stopped" if state is State.STOPPED else "fault"
        if self.job is not None:
            job, self.job = self.job, None
            job.abort()
            self._finish(job.number, job.name, outcome, why, job.recording, job.recording_error)
        for waiting in self.queue:
            self._finish(waiting.number, waiting.name, outcome, why)
        self.queue.clear()
        self._enter(state, why)

    def _restart_sensors_if_needed(self) -> None:
        if any(task.done and task.name == "ranging" for task in self._tasks):
            self.machine.sensors.close()
            self.machine.sensors.start()

    # Small things

    def _finish(
        self,
        number: int,
        name: str,
        outcome: str,
        why: str,
        recording: str | None = None,
        recording_error: str = "",
    ) -> None:
        self._results[number] = JobResult(number, name, outcome, why, recording, recording_error)

    def _enter(self, state: State, why: str = "") -> None:
        with self._lock:
            if state is not self.state:
                self._note("state", state.value + (f": {why}" if why else ""))
            self.state, self.why = state, why

    def _enter_if(self, expected: State, state: State) -> None:
        with self._lock:
            if self.state is expected:
                self._enter(state)

    def _note(self, kind: str, text: str) -> None:
        self.journal.event(self.clock.now_ns(), kind, text)


def seconds(duration_ns: int) -> float:
    """Nanoseconds as seconds."""
    return duration_ns / NS_PER_S


__all__ = ["Controller", "HardwareError"]
