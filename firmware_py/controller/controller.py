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

from drivers.steps.contract import OutputState, OutputStatus, Ticks
from firmware_py.controller.active_job import ActiveJob, Phase
from firmware_py.controller.belief import other_belief
from firmware_py.controller.contract import JobResult, Status
from firmware_py.controller.file_in_force import FileInForce
from firmware_py.controller.homing import Homer
from firmware_py.controller.job_queue import QueuedJob, queued
from firmware_py.controller.journal import Journal
from firmware_py.controller.observer import Observer
from firmware_py.controller.progress import Progress
from firmware_py.controller.ranging_loop import RangingLoop
from firmware_py.controller.report_status import Running, snapshot
from firmware_py.controller.results import Results
from firmware_py.controller.states import Request, State, require
from firmware_py.machine import Machine
from firmware_py.planner.check import home_counts
from firmware_py.planning.prepared import InForce, Prepare, prepare_here
from firmware_py.robot_file import RobotFile
from foundation.clock import NS_PER_S, Task, TaskHandle, ns
from foundation.errors import DeltactlError, NotReady
from models.calibrated_inverse import CalibratedInverse

CONTROL_PERIOD_NS = 10_000_000
MOST_QUEUED = 100
"""A queued job holds its whole plan in memory."""
MOVING = frozenset({State.RUNNING, State.PAUSED})
EMERGENCY = ("e-stop", "stop requested")


class Controller:
    """Runs one robot. Implements `firmware_py.controller.contract.RobotController`."""

    def __init__(
        self,
        robot: RobotFile,
        robot_file: Path,
        machine: Machine,
        recordings: Path,
        prepare: Prepare = prepare_here,
    ):
        """`prepare` reads and plans jobs: here, or in a process of its own."""
        self._prepare = prepare
        self.robot = robot
        self.machine = machine
        self.clock = machine.clock
        self.state = State.OFF
        self.why = ""
        self.job: ActiveJob | None = None
        self.queue: deque[QueuedJob] = deque()
        self.journal = Journal()
        self._belief = CalibratedInverse(robot)
        self._observer = Observer(robot, machine, self.journal)
        self.ranging = RangingLoop(
            machine.sensors,
            self.clock,
            robot.ranging.rate_hz,
            self._observer.reading,
            self._on_sensor_event,
        )
        self._file = FileInForce(robot_file)
        self._recordings = recordings
        self._results = Results()
        self._unfinished: list[tuple[ActiveJob, str, str]] = []
        """Jobs that have ended and whose recordings are not closed yet."""
        self._numbers = itertools.count(1)
        self._lock = threading.RLock()
        self._loops = 0
        self._stop_asked = False
        self._turns = 0
        """Grows whenever what was true of the robot ends: whoever waited compares."""
        self._homing = False
        self._blind_latched = False
        self._lost = ""
        self._beat_ns = self.clock.now_ns()
        self._progress = Progress()
        self._ranging_task: TaskHandle | None = None
        self._control_task = self._start_control()

    def power_on(self) -> None:
        """OFF -> UNHOMED, with the robot file as it is by now, if that needs no restart.

        Raises BusDead, SensorFault, DriveAlarm or EmergencyStop.
        """
        with self._lock:
            require(Request.ON, self.state, self.why)
            turn = self._turns
            newer = self._file.newer(self.robot)
            if newer is not None:
                self._believe(newer, self._file.again())
                if self.machine.world is not None:
                    self.machine.world.believed_anew(newer, self.clock.now_ns())
        self.machine.sensors.start()
        self.machine.output.enable()
        with self._lock:
            self._same(turn, "switch on")
            self._enter(State.UNHOMED)
            self._sensing(True)

    def power_off(self) -> None:
        """-> OFF; the arms may drop. A latched stop or fault stays latched, drives released."""
        with self._lock:
            require(Request.OFF, self.state, self.why)
            self._turns += 1
            self._sensing(False)
            self.machine.output.disable()
            if self.state not in (State.STOPPED, State.FAULT):
                self._enter(State.OFF)
        if self.machine.world is not None:
            self.machine.world.put_to_stops(self.clock.now_ns())

    def home(self, accept_unseen_deg: float = 0.0, robot: Path | None = None) -> str:
        """UNHOMED or READY -> READY, blocking; returns what was seen.

        robot: another file of the same machine, believed from now on. Raises ConfigError for
        one of another, NotReady when the sensors disagree, when they do not determine the arms to
        `accept_unseen_deg`, and when a stop or another request came meanwhile.
        """
        with self._lock:
            require(Request.HOME, self.state, self.why)
            if self._homing:
                raise NotReady("cannot home: the robot is homing already; wait, or stop it")
            if robot is not None:
                named = FileInForce.named(robot)
                self._believe(other_belief(self.robot, named.robot(), robot), named)
            was_ready, turn = self.state is State.READY, self._turns
            self._homing = True
            self._enter(State.UNHOMED, "homing")

        def push(ticks: Ticks) -> None:
            with self._lock:
                self._same(turn, "home")
                self.machine.output.push(ticks)

        try:
            homer = Homer(self.robot, self.machine, self.ranging, push)
            seen = homer.home(was_ready, accept_unseen_deg)
            with self._lock:
                self._same(turn, "home")
                self.machine.output.set_counts(home_counts(self.robot))
                self._observer.restart(self.clock.now_ns())
                self._enter(State.READY)
        except DeltactlError:
            with self._lock:
                self._same(turn, "home")  # the stop is the reason, not what it led to
            raise
        finally:
            with self._lock:
                self._homing = False
                if self.state is State.UNHOMED and self._turns == turn:
                    self._enter(State.UNHOMED)
        self._note("home", seen.says())
        return seen.says()

    def _believe(self, robot: RobotFile, file: FileInForce) -> None:
        """Another robot file is in force from now on; counts mean nothing until homed."""
        if self.queue:
            raise NotReady("cannot take another robot file: jobs wait; cancel them first")
        self.robot, self._file = robot, file
        self._belief = CalibratedInverse(robot)
        self._observer.believe(robot)
        self._note("robot", f"{file.path} is in force")

    def submit(self, job: Path, record: Path | None = None) -> int:
        """Check a job against this robot and queue it; returns its number."""
        with self._lock:
            require(Request.RUN, self.state, self.why)
            turn = self._turns
        number = next(self._numbers)
        prepared = self._prepare(job, InForce(self.robot, self._file.path, self._file.text))
        made = queued(number, job, record, prepared, self._file.text, self._recordings)
        with self._lock:
            require(Request.RUN, self.state, self.why)
            self._same(turn, "run")
            if len(self.queue) >= MOST_QUEUED:
                raise NotReady(f"cannot run: {MOST_QUEUED} jobs wait already; let some end first")
            self.queue.append(made)
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
        self._turns += 1
        self.machine.output.stop(reason)
        with self._lock:
            if self.state in (State.STOPPED, State.FAULT):
                self._note("stop", reason)  # what latched it first stays the reason
            elif self.state is not State.OFF:
                self._halt(State.STOPPED, reason)

    def acknowledge(self) -> None:
        """-> UNHOMED. Raises EmergencyStop, DriveAlarm or NotReady while the cause is there."""
        with self._lock:
            require(Request.ACKNOWLEDGE, self.state, self.why)
            self._must_see()
            turn = self._turns
        self.machine.output.acknowledge()
        self._stop_asked = False
        if self._control_task.done:  # it was an error of its own that is acknowledged
            self._control_task = self._start_control()
        started = self._ranging_task is None or self._ranging_task.done
        if started:
            self.machine.sensors.start()
        self.machine.output.enable()
        with self._lock:
            self._same(turn, "acknowledge")
            self._blind_latched = False
            self._enter(State.UNHOMED)
            if started:
                self._sensing(True)

    def status(self) -> Status:
        """A snapshot."""
        with self._lock:
            waiting = tuple(one.name for one in self.queue)
            sensing = self._ranging_task is not None
            running = Running(
                self.state,
                self.why,
                self.job,
                waiting,
                self.ranging.status(self._observer.blindness_of)
                if sensing
                else self.ranging.status(),
                self.journal.failed,
                self._observer.blind() if sensing else None,
                self._file.changed(self.robot),
                self._file.path.name,
            )
            return snapshot(self.robot, self._belief, self.machine, running)

    def fatal(self) -> str:
        """Why only a new process can go on; empty while this one can."""
        return self._lost

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
            self._ranging_task = None
        if on:
            self._observer.sensors_started(self.clock.now_ns())
            task = self.ranging.task()
            self._ranging_task = self.clock.start("ranging", task, self._on_loop_error)

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
        if seen.lost and not self._lost:
            self._on_output_lost(seen)
        if seen.state is OutputState.STOPPED:
            self._on_output_stopped(seen)
        elif self.job is not None:
            self._drive_unless_stopped(self.job, now_ns)
        elif self.state is State.READY:
            self._rest(now_ns)

    def _rest(self, now_ns: int) -> None:
        """Begin what waits; without a job, see to it that the arms stay where they are."""
        if self.queue:
            self._begin(self.queue.popleft(), now_ns)
        elif (loss := self._observer.lost_steps(now_ns)) is not None:
            self._turns += 1
            self._enter(State.UNHOMED, f"{loss.moved_at_rest()}; home again")

    def _begin(self, job_due: QueuedJob, now_ns: int) -> None:
        blind = self._observer.blind()
        if blind is not None and job_due.job.on_blind == "stop":
            self._results.never_ran(job_due.number, job_due.name, "refused", blind.says())
            return
        job = ActiveJob(job_due, self.robot, self.machine, self.journal)
        try:
            job.begin(now_ns)
            self._observer.feedback = job.feedback
        except DeltactlError as error:
            job.abort()  # the recording that was opened must not stay open
            seen = self.machine.output.status()
            stopped = seen.state is OutputState.STOPPED
            why = seen.reason if stopped else str(error)
            self._finish_later(job, "stopped" if stopped else "refused", why)
            return
        self.job = job
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
        if self._stopped_blind(job):
            return
        job.advance(now_ns)
        if job.phase is Phase.ENDED:
            self.job = None
            self._take_over(job, now_ns)
            self._finish_later(job, "cancelled" if job.cancelled else "done", job.why)
            self._enter(State.READY)

    def _take_over(self, job: ActiveJob, now_ns: int) -> None:
        """Steps that feedback added made up for lost ones: the arms stand where the plan says."""
        feedback, self._observer.feedback = self._observer.feedback, None
        if feedback is not None and feedback.offset.any():
            self._observer.collect()
            self.machine.output.set_counts(feedback.planned(self.machine.output.status().counts))
            self._observer.restart(now_ns)

    def _stopped_blind(self, job: ActiveJob) -> bool:
        """Whether the robot is blind and the job does not want to go on so."""
        blind = self._observer.blind(bears_pauses=True)
        if blind is None:
            job.blind = False
            return False
        if not job.stops_when_blind:
            job.goes_on_blind(blind.says())
            return False
        self.machine.output.stop(blind.says())
        self._halt(State.FAULT, blind.says())
        self._blind_latched = True
        return True

    def _on_sensor_event(self, text: str) -> None:
        self._note("sensor", text)

    # What goes wrong

    def _same(self, turn: int, what: str) -> None:
        """Raise NotReady when a stop, or whatever else ends a wait, came since that turn."""
        if self._turns != turn:
            why = f" ({self.why})" if self.why else ""
            raise NotReady(
                f"cannot {what}: the robot is {self.state.value}{why} meanwhile; ask again"
            )

    def _must_see(self) -> None:
        """A blindness that stopped the robot and is still there is a cause that has not gone."""
        alive = self._ranging_task is not None and not self._ranging_task.done
        blind = self._observer.blind() if alive else None
        if self._blind_latched and blind is not None:
            raise NotReady(
                f"cannot acknowledge: {blind.says()}; mend it, or 'deltactl off' and"
                " 'deltactl acknowledge' to go on without a look"
            )

    def _on_output_lost(self, seen: OutputStatus) -> None:
        """Nobody watches the drives any more: release them from here; this process is done."""
        self._lost = seen.reason

        def task() -> Task:
            yield self.clock.now_ns()
            self._note("fault", f"{seen.reason}: {self.machine.release()}")

        self.clock.start("releasing", task(), self._on_loop_error)

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
        self._turns += 1
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

    def _note(self, kind: str, text: str) -> None:
        self.journal.event(self.clock.now_ns(), kind, text)
