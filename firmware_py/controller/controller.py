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

from drivers.steps.contract import OutputState, OutputStatus
from firmware_py.controller.active_job import ActiveJob, Phase
from firmware_py.controller.contract import JobResult, Status
from firmware_py.controller.homing import Homer
from firmware_py.controller.job_queue import QueuedJob, prepare
from firmware_py.controller.journal import Journal
from firmware_py.controller.observer import Observer
from firmware_py.controller.progress import Progress
from firmware_py.controller.ranging_loop import RangingLoop
from firmware_py.controller.report_status import Running, snapshot
from firmware_py.controller.results import Results
from firmware_py.controller.states import Request, State, require
from firmware_py.machine import Machine
from firmware_py.robot_file import RobotFile
from foundation.clock import NS_PER_S, Task, TaskHandle, ns
from foundation.errors import DeltactlError, NotReady

CONTROL_PERIOD_NS = 10_000_000
MOST_QUEUED = 100
"""A queued job holds its whole plan in memory."""
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
        self._observer = Observer(robot, machine, self.journal)
        self.ranging = RangingLoop(
            machine.sensors,
            self.clock,
            robot.ranging.rate_hz,
            self._observer.reading,
            self._on_sensor_event,
        )
        self._robot_file = robot_file
        self._recordings = recordings
        self._results = Results()
        self._unfinished: list[tuple[ActiveJob, str, str]] = []
        """Jobs that have ended and whose recordings are not closed yet."""
        self._numbers = itertools.count(1)
        self._lock = threading.RLock()
        self._loops = 0
        self._stop_asked = False
        self._beat_ns = self.clock.now_ns()
        self._progress = Progress()
        self._homer = Homer(robot, machine, self.ranging)
        self._ranging_task: TaskHandle | None = None
        self._control_task = self._start_control()

    def power_on(self) -> None:
        """OFF -> UNHOMED. Raises BusDead, SensorFault, DriveAlarm or EmergencyStop."""
        with self._lock:
            require(Request.ON, self.state, self.why)
        self.machine.sensors.start()
        self.machine.output.enable()
        with self._lock:
            self._enter(State.UNHOMED)
            self._sensing(True)

    def power_off(self) -> None:
        """-> OFF; the arms may drop. A latched stop or fault stays latched, drives released."""
        with self._lock:
            require(Request.OFF, self.state, self.why)
            self._sensing(False)
            self.machine.output.disable()
            if self.state not in (State.STOPPED, State.FAULT):
                self._enter(State.OFF)
        if self.machine.world is not None:
            self.machine.world.put_to_stops(self.clock.now_ns())

    def home(self) -> None:
        """UNHOMED or READY -> READY, blocking. Raises NotReady when the sensors disagree."""
        with self._lock:
            require(Request.HOME, self.state, self.why)
            was_ready = self.state is State.READY
            self._enter(State.UNHOMED, "homing")
        try:
            seen = self._homer.home(already_homed=was_ready)
        except BaseException:
            self._enter_if(State.UNHOMED, State.UNHOMED)
            raise
        with self._lock:
            self._observer.restart(self.clock.now_ns())
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
            if len(self.queue) >= MOST_QUEUED:
                raise NotReady(f"cannot run: {MOST_QUEUED} jobs wait already; let some end first")
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

    def cancel(self, job_id: int | None = None) -> None:
        """Decelerate on the path; drop one job, or the one that runs and the queue."""
        with self._lock:
            dropped = [one for one in self.queue if job_id in (None, one.number)]
            running = self.job is not None and job_id in (None, self.job.number)
            if running or not dropped:
                require(Request.CANCEL, self.state, self.why)
            if not running and not dropped:
                raise NotReady(f"job {job_id} is neither running nor queued; see 'deltactl status'")
            for waiting in dropped:
                self.queue.remove(waiting)
                self._results.never_ran(
                    waiting.number, waiting.name, "cancelled", "cancelled while queued"
                )
            if running and self.job is not None:
                self.job.cancel(self.clock.now_ns())
                self._enter(State.RUNNING)

    def stop(self, reason: str) -> None:
        """Emergency stop; takes no lock before the pulses have ended."""
        self._stop_asked = True
        self.machine.output.stop(reason)
        with self._lock:
            if self.state is not State.OFF:
                self._halt(State.STOPPED, reason)

    def acknowledge(self) -> None:
        """-> UNHOMED. Raises EmergencyStop or DriveAlarm while the cause is still there."""
        with self._lock:
            require(Request.ACKNOWLEDGE, self.state, self.why)
        self.machine.output.acknowledge()
        self._stop_asked = False
        if self._control_task.done:  # it was an error of its own that is acknowledged
            self._control_task = self._start_control()
        if self._ranging_task is None or self._ranging_task.done:
            self.machine.sensors.start()
        self.machine.output.enable()
        with self._lock:
            self._enter(State.UNHOMED)
            self._sensing(True)

    def status(self) -> Status:
        """A snapshot."""
        with self._lock:
            queued = tuple(waiting.name for waiting in self.queue)
            sensors, failed = self.ranging.status(), self.journal.failed
            running = Running(self.state, self.why, self.job, queued, sensors, failed)
            return snapshot(self.robot, self.machine, running)

    def result(self, job_id: int) -> JobResult | None:
        """How a job ended; None while it is queued or running."""
        return self._results.of(job_id)

    def progress_count(self) -> int:
        """Grows only while both loops go round (in OFF, STOPPED and FAULT: the control loop)."""
        if self.state in (State.OFF, State.STOPPED, State.FAULT):
            return self._progress.count(control=self._loops)
        return self._progress.count(control=self._loops, ranging=self.ranging.rounds)

    def close(self) -> None:
        """Stop, finish the recording, give the hardware back."""
        with self._lock:
            if self.state in MOVING:
                self._halt(State.STOPPED, "the controller was closed")
            self._sensing(False)
            self._control_task.stop()
        self.machine.close()
        self.journal.close()
        for ended in tuple(self._unfinished):
            self._finish(*ended)

    # The loops

    def _sensing(self, on: bool) -> None:
        """Start or end the ranging loop."""
        if self._ranging_task is not None:
            self._ranging_task.stop()
        task = self.ranging.task()
        self._ranging_task = self.clock.start("ranging", task, self._on_loop_error) if on else None

    def _start_control(self) -> TaskHandle:
        return self.clock.start("control", self._control_loop(), self._on_loop_error)

    def _control_loop(self) -> Task:
        while True:
            with self._lock:
                self._control(self.clock.now_ns())
            self._loops += 1
            yield self.clock.now_ns() + CONTROL_PERIOD_NS

    def _control(self, now_ns: int) -> None:
        output = self.machine.output
        silent_ns, self._beat_ns = now_ns - self._beat_ns, now_ns
        if self.job is not None and silent_ns > ns(self.robot.steps.heartbeat_s):
            # The pulses ran dry in mid-motion before the player missed us: do not just go on.
            output.stop(f"no heartbeat: the controller hung for {silent_ns / NS_PER_S:.1f} s")
        output.beat()
        self._observer.collect()
        seen = output.status()
        if seen.state is OutputState.STOPPED:
            self._on_output_stopped(seen)
        elif self.job is not None:
            self._drive_unless_stopped(self.job, now_ns)
        elif self.state is State.READY and self.queue:
            self._begin(self.queue.popleft(), now_ns)

    def _begin(self, queued: QueuedJob, now_ns: int) -> None:
        try:
            self.job = ActiveJob(queued, self.robot, self.machine, self.journal)
            self.job.begin(now_ns)
        except DeltactlError as error:
            self.job = None
            self._results.never_ran(queued.number, queued.name, "refused", str(error))
            return
        # Opening a file may take long on a slow disk; nothing moved meanwhile.
        self._beat_ns = self.clock.now_ns()
        self._enter(State.RUNNING)

    def _drive_unless_stopped(self, job: ActiveJob, now_ns: int) -> None:
        try:
            self._drive_job(job, now_ns)
        except DeltactlError:
            seen = self.machine.output.status()
            if seen.state is not OutputState.STOPPED:
                raise
            self._on_output_stopped(seen)  # a stop came between the look and the feeding

    def _drive_job(self, job: ActiveJob, now_ns: int) -> None:
        loss = self._observer.lost_steps(now_ns)
        if loss is not None:
            job.lost_steps(loss)
            if job.stops_on_step_loss:
                self.machine.output.stop(loss.says())
                self._halt(State.FAULT, loss.says())
                return
        job.advance(now_ns)
        if job.phase is Phase.ENDED:
            self.job = None
            self._finish_later(job, "cancelled" if job.cancelled else "done", "")
            self._enter(State.READY)

    def _on_sensor_event(self, text: str) -> None:
        self._note("sensor", text)

    # What goes wrong

    def _on_output_stopped(self, seen: OutputStatus) -> None:
        if self.state in (State.STOPPED, State.FAULT):
            return
        emergency = self._stop_asked or any(word in seen.reason for word in EMERGENCY)
        self._halt(State.STOPPED if emergency else State.FAULT, seen.reason)

    def _on_loop_error(self, error: BaseException) -> None:
        """A loop died: stop the pulses first, then say why."""
        self.machine.output.stop(f"fault: {error}")
        with self._lock:
            why = " ".join(str(error).split())
            if self.state in (State.STOPPED, State.FAULT):
                self._note("fault", why)  # what latched it first stays the reason
            else:
                self._halt(State.FAULT, why)

    def _halt(self, state: State, why: str) -> None:
        self._observer.collect()
        self._note("stop" if state is State.STOPPED else "fault", why)
        outcome = "stopped" if state is State.STOPPED else "fault"
        if self.job is not None:
            job, self.job = self.job, None
            job.abort()
            self._finish_later(job, outcome, why)
        for waiting in self.queue:
            self._results.never_ran(waiting.number, waiting.name, outcome, why)
        self.queue.clear()
        self._enter(state, why)

    def _finish_later(self, job: ActiveJob, outcome: str, why: str) -> None:
        """In a task of its own: a disk may take seconds, and nothing must wait for it."""

        def task() -> Task:
            yield self.clock.now_ns()
            self._finish(job, outcome, why)

        self._unfinished.append((job, outcome, why))
        self.clock.start("closing", task(), self._on_loop_error)

    def _finish(self, job: ActiveJob, outcome: str, why: str) -> None:
        """The recording first: who has the result reads it."""
        job.close_recording()
        with self._lock:
            self._results.ran(job, outcome, why)
            if (job, outcome, why) in self._unfinished:
                self._unfinished.remove((job, outcome, why))

    # Small things

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
