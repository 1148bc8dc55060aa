"""The job that runs now: its moves and waits, and a last moment for readings that trail behind."""

from __future__ import annotations

import enum
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass

from deltactl.firmware_py.controller.jobs.feeder import Feeder
from deltactl.firmware_py.controller.jobs.job_queue import QueuedJob
from deltactl.firmware_py.controller.jobs.journal import Journal
from deltactl.firmware_py.controller.jobs.view import View
from deltactl.firmware_py.controller.sensing.step_watch import StepLoss
from deltactl.firmware_py.feedback.feedback import Feedback
from deltactl.firmware_py.job_file import Together
from deltactl.firmware_py.machine import Machine
from deltactl.firmware_py.planner.plan import Plan
from deltactl.firmware_py.planner.stream import MotionStream
from deltactl.firmware_py.planner.summary import slower
from deltactl.firmware_py.planner.time_scaling import TimeScaledMotion
from deltactl.firmware_py.program.instructions import Move, Pause, SetOutputs, Wait, WaitFor
from deltactl.firmware_py.program.totals import totals
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.clock import NS_PER_S, VirtualClock, ns
from deltactl.foundation.errors import NotReady, PulseFault
from deltactl.foundation.release import own_version
from deltactl.recording.format.configuration import RunConfiguration
from deltactl.recording.writing.writer import RunRecorder

Inputs = Mapping[str, Callable[[], bool]]


class Waiting:
    """One wait. Its time stops while the job is paused."""

    def __init__(self, leaf: Wait | WaitFor, now_ns: int, inputs: Inputs):
        timed = isinstance(leaf, Wait)
        most_ns = ns(leaf.seconds if isinstance(leaf, Wait) else leaf.within_s)
        self._leaf, self._inputs = leaf, inputs
        self._until_ns = now_ns + most_ns
        self._paused_ns: int | None = None
        self.planned_ns = most_ns if timed else 0
        """How much of the job's planned time it takes."""

    def over(self, now_ns: int) -> bool:
        """Whether the job may go on."""
        leaf = self._leaf
        if isinstance(leaf, Wait):
            return now_ns >= self._until_ns
        return self._inputs[leaf.input]() == leaf.is_on

    def in_vain(self, now_ns: int) -> bool:
        """Whether what was waited for has not come in time."""
        return isinstance(self._leaf, WaitFor) and now_ns >= self._until_ns

    def pause(self, now_ns: int) -> None:
        """The time stops."""
        self._paused_ns = now_ns

    def resume(self, now_ns: int) -> None:
        """It goes on."""
        if self._paused_ns is not None:
            self._until_ns += now_ns - self._paused_ns
            self._paused_ns = None

    def says(self) -> str:
        """Why it was in vain."""
        assert isinstance(self._leaf, WaitFor)
        return f"waited {self._leaf.within_s:g} s for {self._leaf.says()}, in vain"


SETTLE_S = 0.3
"""Readings of the last moments arrive up to a timing budget and a poll later."""


class Phase(enum.Enum):
    """How far a job is."""

    APPROACH = "approach"
    PATH = "path"
    SETTLE = "settle"
    ENDED = "ended"


@dataclass(frozen=True, slots=True)
class Moving:
    """A move that is under way."""

    plan: Plan
    stream: MotionStream
    motion: TimeScaledMotion
    feeder: Feeder


class ActiveJob:
    """Carries out one queued job, move by move; every call comes from the control loop."""

    def __init__(self, queued: QueuedJob, robot: RobotFile, machine: Machine, journal: Journal):
        self.claim = queued.claim
        self.number = queued.number
        self.name = queued.name
        self.recording: str | None = None
        """Its file, once that is open."""
        self.recording_error = ""
        self.warning = ""
        """What the user should know though the job ran to its end."""
        slow = slower(queued.program.plans())
        self.slower = "" if slow is None else slow.says()
        self.cancelled = False
        self.why = ""
        """Why it cancelled itself."""
        self.blind = False
        self.phase = Phase.APPROACH
        self._queued = queued
        self._robot = robot
        self._machine = machine
        self._journal = journal
        self._settled_ns = 0
        self._recorder: RunRecorder | None = None
        self.feedback: Feedback | None = None
        self._lost_before = machine.bench.memory.lost() if machine.bench else (0, 0, 0)
        self._leaves = queued.program.leaves()
        self._moving: Moving | None = None
        self._standing: Waiting | None = None
        self._paused = False
        self.asks_pause = ""
        """Why the job itself pauses: its control loop enters the state, and takes this away."""
        self._done_ns = self._whole_ns = 0

    def begin(self, now_ns: int) -> None:
        """Open the recording and start moving. Raises RecordingError, UnreachablePoint."""
        program, output = self._queued.program, self._machine.output
        counts = output.status().counts
        self._whole_ns = totals(program, counts).duration_ns
        self._recording = RunRecorder(
            self._queued.recording,
            self._configuration(),
            start_ns=now_ns,
            counts=counts,
            wait_when_behind=isinstance(self._machine.clock, VirtualClock),
        )
        self.recording = str(self._recording.path)
        view = View(self._robot, self._recording)
        view.begin(now_ns, counts)
        self._journal.open(self._recording, view)
        now_ns = self._machine.clock.now_ns()
        if program.job.feedback is not None:
            self.feedback = Feedback(self._robot, program.job.feedback, counts, now_ns)
        self._go_on(now_ns)

    def advance(self, now_ns: int) -> None:
        """Feed the motion, or look whether what is waited for has come."""
        if self.phase is Phase.SETTLE:
            if now_ns >= self._settled_ns:
                self._end()
            return
        if self._moving is not None:
            self._move(self._moving, now_ns)
            return
        self._journal.commanded(now_ns, self._machine.output.status().counts)
        if self.cancelled:
            self._settle(now_ns)
        elif not self._paused and (self._standing is None or self._stood(self._standing, now_ns)):
            self._go_on(now_ns)

    def pause(self, now_ns: int) -> None:
        """Decelerate on the path; where the arms rest, stop the time of the wait."""
        self._paused = True
        if self._moving is not None:
            self._moving.feeder.pause(now_ns)
        if self._standing is not None:
            self._standing.pause(now_ns)
        self._journal.event(now_ns, "pause", self.asks_pause)

    def resume(self, now_ns: int) -> None:
        """Go on."""
        self._paused = False
        if self._moving is not None:
            self._moving.feeder.resume(now_ns)
        if self._standing is not None:
            self._standing.resume(now_ns)
        self._journal.event(now_ns, "resume", "")

    def cancel(self, now_ns: int, why: str = "") -> None:
        """Decelerate, drop the rest, and put outputs safe once the arms are at rest.

        Where only the last readings are waited for, that is now.
        """
        self.cancelled, self.why = True, self.why or why
        if self._moving is not None:
            self._moving.feeder.cancel(now_ns)
        self._journal.event(now_ns, "cancel", why)
        if self.phase is Phase.SETTLE:
            self._make_safe(now_ns)

    def _go_on(self, now_ns: int) -> None:
        """Do what comes next, until something takes time."""
        self._standing = None
        for leaf in self._leaves:
            if isinstance(leaf, Move):
                self._start(leaf.plan)
                return
            if isinstance(leaf, SetOutputs):
                self._switch(leaf.on, leaf.says(), now_ns)
                continue
            if isinstance(leaf, Pause):
                self.asks_pause = leaf.why
                self.pause(now_ns)
                return
            if isinstance(leaf, WaitFor):
                self._journal.event(now_ns, "wait", f"for {leaf.says()}")
            standing = Waiting(leaf, now_ns, self._machine.inputs)
            if not self._stood(standing, now_ns):
                self._standing = standing
                return
        self._settle(now_ns)

    def _start(self, plan: Plan) -> None:
        output, clock = self._machine.output, self._machine.clock
        counts = output.status().counts
        if self.feedback is not None:
            counts = self.feedback.planned(counts)
        self.phase = Phase.APPROACH
        stream = MotionStream(plan, counts)
        self.warning = stream.otherwise or self.warning
        motion = TimeScaledMotion(iter(stream), plan.ramp_s)
        timing = plan.job.timing
        t_pwm_s = timing.t_pwm_s if isinstance(timing, Together) else None
        self._recording.settings(clock.now_ns(), t_pwm_s)
        feeder = Feeder(
            output, self._journal, motion, clock, ns(self._robot.steps.heartbeat_s), self.feedback
        )
        self._moving = Moving(plan, stream, motion, feeder)
        self._journal.event(clock.now_ns(), "approach", f"from counts {counts}")
        feeder.feed(clock.now_ns())  # reading the network's file took a while

    def _move(self, moving: Moving, now_ns: int) -> None:
        feeder = moving.feeder
        feeder.feed(now_ns)
        self._journal.commanded(now_ns, self._machine.output.status().counts)
        past_ns = feeder.motion_ns(now_ns) - moving.stream.path_start_ns
        if self.phase is Phase.APPROACH and past_ns >= 0:
            self.phase = Phase.PATH
            # seen a little late
            self._journal.event(now_ns - past_ns, "path_start", moving.plan.job.name)
        if feeder.finished:
            self._journal.event(now_ns, "path_end", "cancelled" if self.cancelled else "done")
            self._done_ns += moving.stream.end_ns
            self._moving = None
            if self.cancelled:
                self._settle(now_ns)
            elif not self._paused:
                self._go_on(now_ns)

    def _stood(self, standing: Waiting, now_ns: int) -> bool:
        """Whether the wait is over; one that was in vain cancels the job."""
        if standing.over(now_ns):
            self._done_ns += standing.planned_ns
            return True
        if standing.in_vain(now_ns):
            self.cancel(now_ns, standing.says())
        return False

    def _switch(self, on: Mapping[str, bool], says: str, now_ns: int) -> None:
        self._machine.output.switch(*self._machine.switches.levels(on))
        self._journal.event(now_ns, "output", says)

    def _settle(self, now_ns: int) -> None:
        if self.cancelled:
            self._make_safe(now_ns)
        self.phase = Phase.SETTLE
        self._settled_ns = now_ns + ns(SETTLE_S)

    def _make_safe(self, now_ns: int) -> None:
        """However a job ends, but for its own end."""
        pins = self._machine.switches.pins
        if pins:
            self._switch({name: pin.safe for name, pin in pins.items()}, "safe", now_ns)

    @property
    def stops_on_step_loss(self) -> bool:
        """Whether the job asks to be stopped when the sensors see lost steps."""
        return self._queued.job.on_step_loss == "stop" and self.feedback is None

    @property
    def stops_when_blind(self) -> bool:
        """Whether the job asks to be stopped when the sensors do not show the arms."""
        return self._queued.job.on_blind == "stop"

    def goes_on_blind(self, why: str) -> None:
        """The sensors do not show the arms; reported once for each time."""
        if not self.blind:
            self.blind, self.warning = True, why
            self._journal.event(self._machine.clock.now_ns(), "blind", why)

    def lost_steps(self, loss: StepLoss) -> None:
        """The sensors see that steps were lost."""
        self.warning = loss.says()
        kind = "steps_lost" if loss.motor else "sensor"
        self._journal.event(self._machine.clock.now_ns(), kind, loss.says())

    def abort(self) -> None:
        """The pulses have stopped already, or never began: nothing more is recorded."""
        with suppress(NotReady, PulseFault):  # an output that has stopped is safe by itself
            self._make_safe(self._machine.clock.now_ns())
        self._end()

    @property
    def target_m(self) -> tuple[float, float, float] | None:
        """The newest target whose pulses are queued; None between paths."""
        return self._moving.feeder.target_m if self._moving is not None else None

    def progress(self, now_ns: int) -> float:
        """Part done, 0 to 1."""
        if self.phase in (Phase.SETTLE, Phase.ENDED):
            return 1.0
        return min(1.0, self._past_ns(now_ns) / max(1, self._whole_ns))

    def seconds_left(self, now_ns: int) -> float:
        """Robot time left, pauses and waits for inputs not counted."""
        return max(0.0, (self._whole_ns - self._past_ns(now_ns)) / NS_PER_S)

    def _past_ns(self, now_ns: int) -> int:
        moving = self._moving
        return self._done_ns + (moving.feeder.motion_ns(now_ns) if moving is not None else 0)

    def close_recording(self) -> None:
        """Finish the file of a job that has ended, which takes as long as the disk does."""
        if self._recorder is not None:
            self._recorder.close()
            self.recording_error = self._recorder.failed

    def _end(self) -> None:
        self._note_lost_steps()
        says = self.feedback.says() if self.feedback is not None else ""
        if says:
            self.warning = says
            self._journal.event(self._machine.clock.now_ns(), "feedback", says)
        self._recorder = self._journal.detach()
        self.phase = Phase.ENDED

    def _note_lost_steps(self) -> None:
        """Simulated drives know how many edges moved nothing; real ones are watched by sensors."""
        bench = self._machine.bench
        if bench is None:
            return
        for motor, (before, after) in enumerate(
            zip(self._lost_before, bench.memory.lost(), strict=True), start=1
        ):
            if after > before:
                self.warning = (
                    f"simulated drive {motor} lost {after - before} steps: too fast or too sudden"
                    " for its motor; use a longer T_PWM or timing mode 'accelerated'"
                )
                self._journal.event(self._machine.clock.now_ns(), "steps_lost", self.warning)

    def _configuration(self) -> RunConfiguration:
        chosen = self._queued.job.inverse_kinematics
        return RunConfiguration(
            robot_text=self._queued.robot_text,
            job_text=self._queued.job_text,
            robot_name=self._robot.name,
            job_name=self.name,
            version=own_version(),
            simulated=self._machine.simulated,
            settings={"inverse_kinematics": " ".join(chosen.model_dump().values())},
        )
