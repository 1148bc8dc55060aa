"""The controller: takes requests, runs the control loop, and stops safely when anything fails.

Three loops run on the clock: control (every 20 ms: heartbeat, feeding, watching), ranging
(`ranging.rate_hz`), and in simulation a note of the truth. A request only changes state
under the lock; nothing that waits holds it, so that a stop always gets through.
"""

from __future__ import annotations

from pathlib import Path

from deltactl.firmware_py.controller.belief import other_belief
from deltactl.firmware_py.controller.condition import Condition
from deltactl.firmware_py.controller.contract import HomeSeen, JobResult, Status
from deltactl.firmware_py.controller.control_loop import ControlLoop
from deltactl.firmware_py.controller.emergency import LATCHED, Emergency
from deltactl.firmware_py.controller.file_in_force import NAMED, FileInForce
from deltactl.firmware_py.controller.homing import Homing
from deltactl.firmware_py.controller.jobs.job_queue import queued
from deltactl.firmware_py.controller.jobs.jobs import Jobs
from deltactl.firmware_py.controller.jobs.journal import Journal
from deltactl.firmware_py.controller.observer import Observer
from deltactl.firmware_py.controller.progress import Progress
from deltactl.firmware_py.controller.report_status import Running, snapshot
from deltactl.firmware_py.controller.sensing.ranging_loop import RangingLoop
from deltactl.firmware_py.controller.states import Request, State
from deltactl.firmware_py.machine import Machine
from deltactl.firmware_py.planning.prepared import InForce, Prepare, prepare_here
from deltactl.firmware_py.planning.robot_read import ReadRobot, RobotRead, read_robot_here
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.clock import TaskHandle
from deltactl.foundation.errors import NotReady
from deltactl.models.calibrated_inverse import CalibratedInverse

MOVING = frozenset({State.RUNNING, State.PAUSED})


class Controller:
    """Runs one robot. Implements `deltactl.firmware_py.controller.contract.RobotController`."""

    def __init__(
        self,
        robot: RobotFile,
        robot_file: Path,
        machine: Machine,
        recordings: Path,
        prepare: Prepare = prepare_here,
        read: ReadRobot = read_robot_here,
        found: RobotRead | None = None,
    ):
        """`prepare` reads and plans jobs, `read` robot files: here, or in a process of their own.

        found: what the robot file says, where it was read already.
        """
        self._prepare, self._read = prepare, read
        self.robot = robot
        self.machine = machine
        self.clock = machine.clock
        self.journal = Journal()
        self.condition = Condition(self.clock, self.journal, machine.simulated)
        self.jobs = Jobs(self.clock, self.condition.lock, self._on_loop_error)
        self._observer = Observer(robot, machine, self.journal)
        self._emergency = Emergency(machine, self.condition, self.jobs, self._observer)
        self._loop = ControlLoop(
            robot,
            machine,
            self.journal,
            self.condition,
            self.jobs,
            self._observer,
            self._emergency,
        )
        self.ranging = RangingLoop(
            machine.sensors,
            self.clock,
            robot.ranging.rate_hz,
            self._observer.reading,
            lambda text: self.condition.note("sensor", text),
        )
        self._belief = CalibratedInverse(robot)
        self._file = FileInForce(robot_file, read, found=found)
        self._started_with = robot_file
        self._recordings = recordings
        self._homing = Homing(machine, self.ranging, self.condition, self._observer)
        self._progress = Progress()
        self._control_task = self._start_control()

    def power_on(self) -> None:
        """OFF -> UNHOMED, with the robot file as it is by now, if that needs no restart.

        Raises BusDead, SensorFault, DriveAlarm or EmergencyStop.
        """
        with self.condition.lock:
            self.condition.require(Request.ON)
        newer = self._file.newer(self.robot)
        inverse = None if newer is None else CalibratedInverse(newer.robot)
        with self.condition.lock:
            self.condition.require(Request.ON)
            turn = self.condition.turns
            if newer is not None and inverse is not None:
                self._believe(newer.robot, newer, inverse)
                if self.machine.world is not None:
                    self.machine.world.believed_anew(newer.robot, self.clock.now_ns())
        self.machine.sensors.start()
        self.machine.output.enable()
        with self.condition.lock:
            self.condition.same(turn, "switch on")
            self.condition.enter(State.UNHOMED)
            self._sense()

    def power_off(self) -> None:
        """-> OFF; the arms may drop. A latched stop or fault stays latched, drives released."""
        with self.condition.lock:
            self.condition.require(Request.OFF)
            self.condition.turns += 1
            self.ranging.stop()
            self.machine.output.disable()
            if self.condition.state not in LATCHED:
                self.condition.enter(State.OFF)
        if self.machine.world is not None:
            self.machine.world.put_to_stops(self.clock.now_ns())

    def home(self, accept_unseen_deg: float = 0.0, robot: Path | None = None) -> HomeSeen:
        """UNHOMED or READY -> READY, blocking; returns what was seen.

        robot: another file of the same machine, believed from now on. Raises ConfigError for
        one of another, NotReady when the sensors disagree, when they do not determine the arms to
        `accept_unseen_deg`, and when a stop or another request came meanwhile.
        """
        with self.condition.lock:
            self.condition.require(Request.HOME)
            turn = self.condition.turns
        if robot is None:
            return self._homing.home(lambda: self.robot, accept_unseen_deg)
        # Read before the lock is taken: a wrong file may take a second or two.
        named = FileInForce(robot, self._read, NAMED)
        other = other_belief(self.robot, named.robot, robot)
        inverse = CalibratedInverse(other)

        def believed() -> RobotFile:
            self.condition.same(turn, "home")
            self._believe(other, named, inverse)
            return other

        return self._homing.home(believed, accept_unseen_deg)

    def _believe(self, robot: RobotFile, file: FileInForce, inverse: CalibratedInverse) -> None:
        """Another robot file is in force from now on; counts mean nothing until homed."""
        if self.jobs.queue:
            raise NotReady("cannot take another robot file: jobs wait; cancel them first")
        self.robot, self._file, self._loop.robot = robot, file, robot
        self._belief = inverse
        self._observer.believe(robot)
        self.condition.note("robot", f"{file.path} is in force")

    def submit(self, job: Path, record: Path | None = None) -> int:
        """Check a job against this robot and queue it; returns its number."""
        with self.condition.lock:
            self.condition.require(Request.RUN)
            turn = self.condition.turns
        number = self.jobs.next_number()
        file = self._file
        started = None if file.path == self._started_with else self._started_with
        prepared = self._prepare(job, InForce(self.robot, file.path, file.text, started))
        made = queued(number, job, record, prepared, file.text, self._recordings)
        if self.jobs.running is None and not self.jobs.queue:
            made.check_way_in(self.machine.output.status().counts)
        with self.condition.lock:
            self.condition.require(Request.RUN)
            self.condition.same(turn, "run")
            self.jobs.add(made)
        return number

    def pause(self) -> None:
        """Decelerate on the path and hold."""
        with self.condition.lock:
            self.condition.require(Request.PAUSE)
            assert self.jobs.running is not None
            self.jobs.running.pause(self.clock.now_ns())
            self.condition.enter(State.PAUSED)

    def resume(self) -> None:
        """Go on along the path."""
        with self.condition.lock:
            self.condition.require(Request.RESUME)
            assert self.jobs.running is not None
            self.jobs.running.resume(self.clock.now_ns())
            self.condition.enter(State.RUNNING)

    def cancel(self, job_id: int | None = None) -> None:
        """Decelerate on the path; drop one job, or the one that runs and the queue."""
        with self.condition.lock:
            dropped, running = self.jobs.waiting(job_id), self.jobs.runs(job_id)
            if running or not dropped:
                self.condition.require(Request.CANCEL)
            if not running and not dropped:
                raise NotReady(f"job {job_id} is neither running nor queued; see 'deltactl status'")
            self.jobs.drop(dropped)
            if running and self.jobs.running is not None:
                self.jobs.running.cancel(self.clock.now_ns())
                self.condition.enter(State.RUNNING)

    def stop(self, reason: str) -> None:
        """Emergency stop; takes no lock before the pulses have ended."""
        self._emergency.stop(reason)

    def acknowledge(self) -> None:
        """-> UNHOMED. Raises EmergencyStop, DriveAlarm or NotReady while the cause is there."""
        self._homing.wait_for_end()
        with self.condition.lock:
            self.condition.require(Request.ACKNOWLEDGE)
            self._emergency.must_see(self._observer.blind() if self.ranging.alive else None)
            turn = self.condition.turns
        self.machine.output.acknowledge()
        self._emergency.stop_asked = False
        if self._control_task.done:  # it was an error of its own that is acknowledged
            self._control_task = self._start_control()
        started = not self.ranging.alive
        if started:
            self.machine.sensors.start()
        self.machine.output.enable()
        with self.condition.lock:
            self.condition.same(turn, "acknowledge")
            self._emergency.blind_latched = False
            self.condition.enter(State.UNHOMED)
            if started:
                self._sense()

    def status(self) -> Status:
        """A snapshot."""
        changed = self._file.changed(self.robot)
        with self.condition.lock:
            waiting = tuple(one.name for one in self.jobs.queue)
            sensing = self.ranging.started
            running = Running(
                self.condition.state,
                self.condition.why,
                self.jobs.running,
                waiting,
                self.ranging.status(self._observer.blindness_of)
                if sensing
                else self.ranging.status(),
                self.journal.failed,
                self._observer.blind() if sensing else None,
                tuple(one.number for one in self.jobs.queue),
                changed,
                self._file.path.name,
                str(self._file.path.absolute()),
            )
            return snapshot(self.robot, self._belief, self.machine, running)

    def fatal(self) -> str:
        """Why only a new process can go on; empty while this one can."""
        return self._emergency.lost

    def result(self, job_id: int) -> JobResult | None:
        """How a job ended; None while it is queued or running."""
        return self.jobs.result(job_id)

    def progress_count(self) -> int:
        """Grows only while both loops go round (in OFF, STOPPED and FAULT: the control loop)."""
        if self.condition.state in {State.OFF, *LATCHED}:
            return self._progress.count(control=self._loop.rounds)
        return self._progress.count(control=self._loop.rounds, ranging=self.ranging.rounds)

    def close(self) -> None:
        """Stop, finish the recording, give the hardware back."""
        with self.condition.lock:
            if self.condition.state in MOVING:
                self._emergency.halt(State.STOPPED, "the controller was closed")
            self.ranging.stop()
            self._control_task.stop()
        self.machine.close()
        self.journal.close()
        self.jobs.finish_now()

    def _sense(self) -> None:
        """Start the ranging loop, anew where one has died."""
        self.ranging.stop()
        self._observer.sensors_started(self.clock.now_ns())
        self.ranging.start(self._on_loop_error)

    def _start_control(self) -> TaskHandle:
        return self.clock.start("control", self._loop.task(), self._on_loop_error)

    def _on_loop_error(self, error: BaseException) -> None:
        """Of any loop."""
        self._emergency.loop_died(error)
