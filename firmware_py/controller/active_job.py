"""The job that runs now: approach, path, and a last moment for the readings that trail behind."""

from __future__ import annotations

import enum
from importlib.metadata import PackageNotFoundError, version

from firmware_py.controller.feeder import Feeder
from firmware_py.controller.job_queue import QueuedJob
from firmware_py.controller.journal import Journal
from firmware_py.controller.step_watch import StepLoss
from firmware_py.controller.view import View
from firmware_py.feedback.feedback import Feedback
from firmware_py.job_file import Together
from firmware_py.machine import Machine
from firmware_py.planner.stream import MotionStream
from firmware_py.planner.time_scaling import TimeScaledMotion
from firmware_py.robot_file import RobotFile
from foundation.clock import NS_PER_S, VirtualClock, ns
from recording.configuration import RunConfiguration
from recording.writer import RunRecorder

SETTLE_S = 0.3
"""Readings of the last moments arrive up to a timing budget and a poll later."""


class Phase(enum.Enum):
    """How far a job is."""

    APPROACH = "approach"
    PATH = "path"
    SETTLE = "settle"
    ENDED = "ended"


class ActiveJob:
    """Drives one queued job through its phases; every call comes from the control loop."""

    def __init__(self, queued: QueuedJob, robot: RobotFile, machine: Machine, journal: Journal):
        self.number = queued.number
        self.name = queued.name
        self.recording = str(queued.recording)
        self.recording_error = ""
        self.warning = ""
        """What the user should know though the job ran to its end."""
        self.cancelled = False
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

    def begin(self, now_ns: int) -> None:
        """Open the recording and start moving. Raises RecordingError, UnreachablePoint."""
        plan, output = self._queued.plan, self._machine.output
        counts = output.status().counts
        self._stream = MotionStream(plan, counts)
        self._motion = TimeScaledMotion(iter(self._stream), plan.ramp_s)
        recorder = RunRecorder(
            self._queued.recording,
            self._configuration(),
            start_ns=now_ns,
            counts=counts,
            wait_when_behind=isinstance(self._machine.clock, VirtualClock),
        )
        view = View(self._robot, recorder)
        view.begin(now_ns, counts)
        self._journal.open(recorder, view)
        timing = plan.job.timing
        t_pwm_s = timing.t_pwm_s if isinstance(timing, Together) else None
        recorder.settings(now_ns, t_pwm_s)
        now_ns = self._machine.clock.now_ns()
        heartbeat_ns = ns(self._robot.steps.heartbeat_s)
        clock = self._machine.clock
        if plan.job.feedback is not None:
            self.feedback = Feedback(self._robot, plan.job.feedback, counts, now_ns)
        self._feeder = Feeder(
            output, self._journal, self._motion, clock, heartbeat_ns, self.feedback
        )
        self._journal.event(now_ns, "approach", f"from counts {counts}")
        self._feeder.feed(clock.now_ns())  # reading the network's file took a while

    def advance(self, now_ns: int) -> None:
        """Feed the motion and move on to the next phase when it is time."""
        if self.phase is Phase.SETTLE:
            if now_ns >= self._settled_ns:
                self._end()
            return
        self._feeder.feed(now_ns)
        self._journal.commanded(now_ns, self._machine.output.status().counts)
        past_ns = self._feeder.motion_ns(now_ns) - self._stream.path_start_ns
        if self.phase is Phase.APPROACH and past_ns >= 0:
            self.phase = Phase.PATH
            self._journal.event(now_ns - past_ns, "path_start", self.name)  # seen a little late
        if self._feeder.finished:
            self._journal.event(now_ns, "path_end", "cancelled" if self.cancelled else "done")
            self.phase = Phase.SETTLE
            self._settled_ns = now_ns + ns(SETTLE_S)

    def pause(self, now_ns: int) -> None:
        """Decelerate on the path."""
        self._motion.pause(self._feeder.run_ns(now_ns))
        self._journal.event(now_ns, "pause", "")

    def resume(self, now_ns: int) -> None:
        """Go on."""
        self._motion.resume(self._feeder.run_ns(now_ns))
        self._journal.event(now_ns, "resume", "")

    def cancel(self, now_ns: int) -> None:
        """Decelerate and drop the rest."""
        self.cancelled = True
        self._motion.cancel(self._feeder.run_ns(now_ns))
        self._journal.event(now_ns, "cancel", "")

    @property
    def stops_on_step_loss(self) -> bool:
        """Whether the job asks to be stopped when the sensors see lost steps."""
        return self._queued.plan.job.on_step_loss == "stop" and self.feedback is None

    @property
    def stops_when_blind(self) -> bool:
        """Whether the job asks to be stopped when the sensors do not show the arms."""
        return self._queued.plan.job.on_blind == "stop"

    def goes_on_blind(self, why: str) -> None:
        """The sensors do not show the arms; told once for each time."""
        if not self.blind:
            self.blind, self.warning = True, why
            self._journal.event(self._machine.clock.now_ns(), "blind", why)

    def lost_steps(self, loss: StepLoss) -> None:
        """The sensors see that steps were lost."""
        self.warning = loss.says()
        self._journal.event(self._machine.clock.now_ns(), "steps_lost", loss.says())

    def abort(self) -> None:
        """The pulses have stopped already: nothing more is recorded."""
        self._end()

    def progress(self, now_ns: int) -> float:
        """Part done, 0 to 1."""
        if self.phase in (Phase.SETTLE, Phase.ENDED):
            return 1.0
        return min(1.0, self._feeder.motion_ns(now_ns) / max(1, self._stream.end_ns))

    def seconds_left(self, now_ns: int) -> float:
        """Robot time left, pauses not counted."""
        left_ns = self._stream.end_ns - self._feeder.motion_ns(now_ns)
        return max(0.0, left_ns / NS_PER_S)

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
        chosen = self._queued.plan.job.inverse_kinematics
        return RunConfiguration(
            robot_text=self._queued.robot_text,
            job_text=self._queued.job_text,
            robot_name=self._robot.name,
            job_name=self.name,
            version=software_version(),
            simulated=self._machine.simulated,
            settings={"inverse_kinematics": " ".join(chosen.model_dump().values())},
        )


def software_version() -> str:
    """Version of the installed package."""
    try:
        return version("deltactl")
    except PackageNotFoundError:
        return "unknown"
