"""The controller: takes requests, runs the control loop, and stops safely when anything fails.

Three loops run on the clock: control (every 20 ms: heartbeat, feeding, watching), ranging
(`ranging.rate_hz`), and in simulation a note of the truth. A request only changes state
under the lock; nothing that waits holds it, so that a stop always gets through.
"""

from __future__ import annotations

from pathlib import Path

from deltactl.firmware_py.controller.accepted_file import other_accepted
from deltactl.firmware_py.controller.claim import CLIENT_WENT, Claim, Owner
from deltactl.firmware_py.controller.condition import Condition
from deltactl.firmware_py.controller.contract import HomeSeen, JobResult, Status
from deltactl.firmware_py.controller.control_loop import ControlLoop, Progress
from deltactl.firmware_py.controller.emergency import LATCHED, Emergency
from deltactl.firmware_py.controller.file_in_force import NAMED, FileInForce, keep_text
from deltactl.firmware_py.controller.homing import Homing
from deltactl.firmware_py.controller.jobs.job_queue import QueuedJob, queued
from deltactl.firmware_py.controller.jobs.jobs import Jobs
from deltactl.firmware_py.controller.jobs.journal import Journal
from deltactl.firmware_py.controller.observer import Observer
from deltactl.firmware_py.controller.report_status import Running, snapshot
from deltactl.firmware_py.controller.sensing.ranging_loop import RangingLoop
from deltactl.firmware_py.controller.states import (
    ENGAGED,
    Ends,
    Happening,
    Request,
    Rule,
    State,
)
from deltactl.firmware_py.controller.trial import Accepted, Trial
from deltactl.firmware_py.machine import Machine
from deltactl.firmware_py.planning.prepared import (
    InForce,
    Prepare,
    ReadRobot,
    RobotRead,
    prepare_for,
    read_robot_here,
)
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.clock import TaskHandle
from deltactl.foundation.errors import NotReady
from deltactl.models.calibrated_inverse import CalibratedInverse

BEFORE_IT_BEGAN = "cancelled before it began"
"""Said of a job that never ran, and to whoever waits for its check."""


class Controller:
    """Runs one robot. Implements `deltactl.firmware_py.controller.contract.RobotController`."""

    def __init__(
        self,
        robot: RobotFile,
        robot_file: Path,
        machine: Machine,
        recordings: Path,
        prepare: Prepare = prepare_for,
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
        self._calibrated = CalibratedInverse(robot)
        self._offs = 0
        """How often the drives were released."""
        self._file = FileInForce(robot_file, read, found=found)
        self._started_with = robot_file
        self._recordings = recordings
        self._trial = Trial(self.condition, lambda file: self._accept(*file))
        self._loop.each_round = self._trial.settle
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
                self._accept(newer.robot, newer, inverse)
                if self.machine.world is not None:
                    self.machine.world.accepted_anew(newer.robot, self.clock.now_ns())
        self.machine.sensors.start()
        self._energise(turn, "switch on")
        with self.condition.lock:
            self.condition.same(turn, "switch on")
            self.condition.go(Request.ON)
            self._sense()

    def power_off(self) -> None:
        """-> OFF; the arms may drop. A latched stop or fault stays latched, drives released.

        What is planned or waits is dropped, and a homing ends.
        """
        with self.condition.lock:
            rule = self.condition.require(Request.OFF)
            self.condition.turns += 1
            self._offs += 1
            self._call_off(rule, "the robot was switched off")
            self.ranging.stop()
            self.machine.output.disable()
            self._homing.released()
            self.condition.go(Request.OFF, why=self.condition.why)
        if self.machine.world is not None:
            self.machine.world.put_to_stops(self.clock.now_ns())

    def _energise(self, turn: int, what: str) -> None:
        """Energise the drives, unless something came since that turn, or comes meanwhile."""
        with self.condition.lock:
            self.condition.same(turn, what)
            offs = self._offs
        self.machine.output.enable()
        with self.condition.lock:
            if self._offs != offs:
                self.machine.output.disable()

    def home(
        self,
        accept_unseen_deg: float = 0.0,
        robot: Path | None = None,
        claim: Claim | None = None,
        trial: bool = False,
    ) -> HomeSeen:
        """UNHOMED or READY -> READY, blocking; returns what was seen.

        robot: another file of the same machine, in force from now on; on trial, until its client
        goes. Raises ConfigError for one of another, NotReady when the sensors disagree, when they
        do not determine the arms to `accept_unseen_deg`, and when a stop or another request came.
        """
        claim = claim or Claim()
        with self.condition.lock:
            self.condition.require(Request.HOME)
            turn = self.condition.turns
        if robot is None:

            def in_force() -> RobotFile:
                self._trial.end_unless_of(claim)
                return self.robot

            return self._homing.home(in_force, accept_unseen_deg, claim)
        # Read before the lock is taken: a wrong file may take a second or two.
        named = FileInForce(robot, self._read, NAMED)
        other = other_accepted(self.robot, named.robot, robot)
        inverse = CalibratedInverse(other)

        def accepted() -> RobotFile:
            self.condition.same(turn, "home")
            before = Accepted(self.robot, self._file, self._calibrated)
            self._accept(other, named, inverse)
            self._trial.taken(before, claim, trial)
            return other

        return self._homing.home(accepted, accept_unseen_deg, claim)

    def _accept(self, robot: RobotFile, file: FileInForce, inverse: CalibratedInverse) -> None:
        """Another robot file is in force from now on; counts mean nothing until homed."""
        if self.jobs.queue:
            raise NotReady("cannot take another robot file: jobs wait; cancel them first")
        keep_text(file.text)
        self.robot, self._file, self._loop.robot = robot, file, robot
        self._calibrated = inverse
        self._observer.accept(robot)
        self.condition.note("robot", f"{file.path} is in force")

    def submit(self, job: Path, record: Path | None = None, claim: Claim | None = None) -> int:
        """Check a job against this robot and queue it; returns its number.

        Raises what is wrong with the job, and NotReady when it was called off meanwhile.
        """
        claim = claim or Claim()
        self.accept(job, claim)
        self.check(job, record, claim)
        return claim.number

    def accept(self, job: Path, claim: Claim) -> None:
        """Take a job, which is checked from now on; its number is in the claim."""
        with self.condition.lock:
            self.condition.require(Request.RUN)
            self._trial.must_be_of(claim)
            claim.turn = self.condition.turns
            self.jobs.plan(claim, job.stem)
            self.condition.go(Request.RUN, self.jobs.state())

    def check(self, job: Path, record: Path | None, claim: Claim) -> None:
        """Check a job that was accepted, and queue it. Raises what `submit` does."""
        try:
            claim.must_hold("run")
            made = self._checked(job, record, claim)
            with self.condition.lock:
                claim.must_hold("run")
                self.condition.require(Request.RUN)
                self.condition.same(claim.turn, "run")
                self.jobs.add(made)
        except BaseException as error:
            with self.condition.lock:
                refused = self.jobs.refused(claim, str(error))
                if refused and self.condition.rule(Happening.ENDED) is not None:
                    self.condition.go(Happening.ENDED, self.jobs.state())
            claim.must_hold("run")  # whoever called it off is the reason, not what that led to
            raise

    def _checked(self, job: Path, record: Path | None, claim: Claim) -> QueuedJob:
        file = self._file
        started = None if file.path == self._started_with else self._started_with
        in_force = InForce(self.robot, file.path, file.text, started)
        prepared = self._prepare(job, in_force, claim)
        with self.condition.lock:
            taken = {one.recording for one in self.jobs.queue}
        made = queued(claim, job, record, prepared, file.text, self._recordings, taken)
        if self.jobs.is_next(claim):
            made.check_way_in(self.machine.output.status().counts)
        return made

    def pause(self) -> None:
        """Decelerate on the path and hold; what has not begun is held."""
        with self.condition.lock:
            self.condition.require(Request.PAUSE)
            self.jobs.pause(self.clock.now_ns())
            self.condition.go(Request.PAUSE, self.jobs.state())

    def resume(self) -> None:
        """Go on along the path."""
        with self.condition.lock:
            self.condition.require(Request.RESUME)
            self.jobs.resume(self.clock.now_ns())
            self.condition.go(Request.RESUME, self.jobs.state())

    def cancel(self, job_id: int | None = None) -> None:
        """Drop one job, or all and a homing; one that runs decelerates on the path."""
        with self.condition.lock:
            rule = self.condition.require(Request.CANCEL)
            if job_id is None:
                self._call_off(rule, BEFORE_IT_BEGAN)
            elif self.jobs.known(job_id):
                self.jobs.call_off(rule.ends, BEFORE_IT_BEGAN, lambda one: one.number == job_id)
            else:
                raise NotReady(f"job {job_id} is neither running nor queued; see 'deltactl status'")
            homing = Ends.HOMING in rule.ends
            self.condition.go(Request.CANCEL, None if homing else self.jobs.state())

    def move(self, job_id: int, place: int) -> None:
        """Give a job that waits another place in the queue. Raises NotReady where it does not."""
        with self.condition.lock:
            self.jobs.move(job_id, place)

    def leave(self, owner: Owner) -> None:
        """A client has gone: what it asked for, and was not detached, moves nothing any more."""
        with self.condition.lock:
            owner.gone = True
            rule = self.condition.rule(Happening.GONE)
            if rule is not None and Ends.HOMING in rule.ends:
                if self._homing.call_off(CLIENT_WENT, owner):
                    self.condition.go(Happening.GONE)
            elif rule is not None and any(one.owner is owner for one in self.jobs.claims()):
                self.jobs.call_off(rule.ends, CLIENT_WENT, lambda one: one.owner is owner)
                self.condition.go(Happening.GONE, self.jobs.state())
            self._trial.leave(owner)

    def owes(self, owner: Owner) -> bool:
        """Whether anything that this client asked for has not ended."""
        with self.condition.lock:
            return any(one.owner is owner for one in self.jobs.claims())

    def _call_off(self, rule: Rule, why: str) -> None:
        """What the table says that an event ends."""
        if Ends.HOMING in rule.ends:
            self._homing.call_off(why)
        self.jobs.call_off(rule.ends, why)

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
        self._energise(turn, "acknowledge")
        with self.condition.lock:
            self.condition.same(turn, "acknowledge")
            self._emergency.blind_latched = False
            self.condition.go(Request.ACKNOWLEDGE)
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
                tuple((one.number, one.name) for one in self.jobs.planned),
                changed,
                self._file.path.name,
                str(self._file.path.absolute()),
            )
            return snapshot(self.robot, self._calibrated, self.machine, running)

    def fatal(self) -> str:
        """Why only a new process can go on; empty while this one can."""
        return self._emergency.lost

    def result(self, job_id: int) -> JobResult | None:
        """How a job ended; None while it is planned, queued or running. Raises ServiceError."""
        with self.condition.lock:
            return self.jobs.result(job_id)

    def progress_count(self) -> int:
        """Grows only while both loops go round (in OFF, STOPPED and FAULT: the control loop)."""
        if self.condition.state in {State.OFF, *LATCHED}:
            return self._progress.count(control=self._loop.rounds)
        return self._progress.count(control=self._loop.rounds, ranging=self.ranging.rounds)

    def close(self) -> None:
        """Stop, finish the recording, give the hardware back."""
        with self.condition.lock:
            if self.condition.state in ENGAGED:
                self._emergency.halt(Request.STOP, "the controller was closed")
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
        """Stop for the error of any loop."""
        self._emergency.loop_died(error)
