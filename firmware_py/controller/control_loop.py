"""The control loop: every 20 ms a heartbeat, what the output did, and the job that runs."""

from __future__ import annotations

from collections.abc import Callable

from deltactl.drivers.steps.contract import OutputState
from deltactl.firmware_py.controller.condition import Condition
from deltactl.firmware_py.controller.emergency import Emergency
from deltactl.firmware_py.controller.jobs.active_job import ActiveJob, Phase
from deltactl.firmware_py.controller.jobs.job_queue import QueuedJob
from deltactl.firmware_py.controller.jobs.jobs import Jobs
from deltactl.firmware_py.controller.jobs.journal import Journal
from deltactl.firmware_py.controller.observer import Observer
from deltactl.firmware_py.controller.states import Happening
from deltactl.firmware_py.machine import Machine
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.clock import NS_PER_S, Task, ns
from deltactl.foundation.errors import DeltactlError

CONTROL_PERIOD_NS = 20_000_000
"""A fifth of what is queued ahead; e-stop, alarms and a dead controller are the pulse player's."""


class ControlLoop:
    """Goes round under the controller's lock; what it feeds is what the output sends."""

    def __init__(
        self,
        robot: RobotFile,
        machine: Machine,
        journal: Journal,
        condition: Condition,
        jobs: Jobs,
        observer: Observer,
        emergency: Emergency,
    ):
        self.robot = robot
        """The robot file in force."""
        self.rounds = 0
        self._machine = machine
        self._clock = machine.clock
        self._journal = journal
        self._condition = condition
        self._jobs = jobs
        self._observer = observer
        self._emergency = emergency
        self.each_round: Callable[[], None] = lambda: None
        """Called at the end of each round, with the lock held."""
        self._beat_ns = self._clock.now_ns()

    def task(self) -> Task:
        """For ever."""
        while True:
            with self._condition.lock:
                self._round(self._clock.now_ns())
                self.each_round()
            self.rounds += 1
            yield self._clock.now_ns() + CONTROL_PERIOD_NS

    def _round(self, now_ns: int) -> None:
        output = self._machine.output
        silent_ns, self._beat_ns = now_ns - self._beat_ns, now_ns
        if self._jobs.running is not None and silent_ns > ns(self.robot.steps.heartbeat_s):
            # The pulses ran dry in mid-motion before the player missed us: do not just go on.
            output.stop(f"no heartbeat: the controller hung for {silent_ns / NS_PER_S:.1f} s")
        output.beat()
        self._observer.collect()
        self._observer.note_truth(now_ns)
        seen = output.status()
        if seen.lost and not self._emergency.lost:
            self._emergency.output_lost(seen)
        if seen.state is OutputState.STOPPED:
            self._emergency.output_stopped(seen)
        elif self._jobs.running is not None:
            self._drive_unless_stopped(self._jobs.running, now_ns)
        elif self._condition.rule(Happening.PUSHED) is not None:
            self._rest(now_ns)

    def _rest(self, now_ns: int) -> None:
        """See to it that the arms stay where they are; begin what waits."""
        if (loss := self._observer.lost_steps(now_ns)) is not None:
            self._condition.turns += 1
            why = f"{loss.moved_at_rest()}; home again"
            self._jobs.end_all("refused", why)
            self._condition.go(Happening.PUSHED, why=why)
        elif self._jobs.queue and self._condition.rule(Happening.BEGUN) is not None:
            self._begin(self._jobs.queue.popleft(), now_ns)

    def _begin(self, job_due: QueuedJob, now_ns: int) -> None:
        blind = self._observer.blind()
        if blind is not None and job_due.job.on_blind == "stop":
            self._jobs.never_ran(job_due, "refused", blind.says())
            self._condition.go(Happening.ENDED, self._jobs.state())
            return
        job = ActiveJob(job_due, self.robot, self._machine, self._journal)
        try:
            job.begin(now_ns)
            self._observer.feedback = job.feedback
        except DeltactlError as error:
            job.abort()  # the recording that was opened must not stay open
            seen = self._machine.output.status()
            stopped = seen.state is OutputState.STOPPED
            why = seen.reason if stopped else str(error)
            self._jobs.finish_later(job, "stopped" if stopped else "refused", why)
            self._condition.go(Happening.ENDED, self._jobs.state())
            return
        self._jobs.running = job
        # Opening a file may take long on a slow disk; nothing moved meanwhile.
        self._beat_ns = self._clock.now_ns()
        self._condition.go(Happening.BEGUN)

    def _drive_unless_stopped(self, job: ActiveJob, now_ns: int) -> None:
        try:
            self._drive(job, now_ns)
        except DeltactlError:
            seen = self._machine.output.status()
            if seen.state is not OutputState.STOPPED:
                raise
            self._emergency.output_stopped(seen)  # a stop came between the look and the feeding

    def _drive(self, job: ActiveJob, now_ns: int) -> None:
        if self._clock.now_ns() - now_ns > ns(self.robot.steps.heartbeat_s):
            return  # hung within this round, no sensor's fault: the next round says so and stops
        loss = self._observer.lost_steps(now_ns)
        if loss is not None:
            job.lost_steps(loss)
            if job.stops_on_step_loss:
                self._emergency.fault(loss.says())
                return
        if self._stopped_blind(job):
            return
        job.advance(now_ns)
        if job.asks_pause and self._condition.rule(Happening.WAITS) is not None:
            self._jobs.held = True
            self._condition.go(Happening.WAITS, why=job.asks_pause)
            job.asks_pause = ""
        if job.phase is Phase.ENDED:
            self._jobs.running = None
            self._take_over(now_ns)
            self._jobs.finish_later(job, "cancelled" if job.cancelled else "done", job.why)
            self._condition.go(Happening.ENDED, self._jobs.state())

    def _take_over(self, now_ns: int) -> None:
        """Steps that feedback added replaced lost ones: the arms are where the plan says."""
        feedback, self._observer.feedback = self._observer.feedback, None
        if feedback is not None and feedback.offset.any():
            output = self._machine.output
            self._observer.collect()
            output.set_counts(feedback.planned(output.status().counts))
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
        self._emergency.fault(blind.says())
        self._emergency.blind_latched = True
        return True


class Progress:
    """Proof that every loop goes round: counts the times at which all had moved on since the last.

    A smallest of counters would not do: a loop that is ahead could hang unnoticed until the
    slowest has caught up, and the result would fall when another loop joins in.
    """

    def __init__(self) -> None:
        self._count = 0
        self._seen: dict[str, int] = {}

    def count(self, **rounds: int) -> int:
        """Look at the loops' own counters now; returns how often all have moved."""
        if all(self._seen.get(name) != value for name, value in rounds.items()):
            self._seen |= rounds
            self._count += 1
        return self._count
