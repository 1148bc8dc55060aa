"""Keeps the step output fed a little ahead of time, and notes which targets are reached.

Only `LOOKAHEAD_S` of motion is ever queued: a pause begins that soon, and when the
controller dies the pulses run dry as soon (the heartbeat ends them sooner).
"""

from __future__ import annotations

from deltactl.drivers.steps.contract import OutputState, OutputStatus, StepOutput, Ticks
from deltactl.firmware_py.controller.jobs.journal import Journal
from deltactl.firmware_py.feedback.feedback import Feedback
from deltactl.firmware_py.planner.motion import Reached
from deltactl.firmware_py.planner.time_scaling import Pace, Pacing, TimeScaledMotion
from deltactl.foundation.clock import NS_PER_S, Clock, ns
from deltactl.foundation.errors import PulseFault

LOOKAHEAD_S = 0.1
LEAD_S = 0.03
"""The first tick is due this long after the start, so that it is not late at once."""


class Feeder:
    """Plays one motion on a step output. Times along the motion are run times of the warp."""

    def __init__(
        self,
        output: StepOutput,
        journal: Journal,
        motion: TimeScaledMotion,
        clock: Clock,
        heartbeat_ns: int,
        feedback: Feedback | None = None,
    ):
        self._output = output
        self._clock = clock
        self._heartbeat_ns = heartbeat_ns
        self._journal = journal
        self._motion = motion
        self._feedback = feedback
        self._start_ns = clock.now_ns() + ns(LEAD_S)
        self.target_m: tuple[float, float, float] | None = None
        """The newest one that was queued."""
        self._slip_before_ns = output.status().slip_ns

    @property
    def finished(self) -> bool:
        """Whether everything was handed on and played."""
        return self._motion.pacing() is Pacing.DONE and _is_still(self._output.status())

    def run_ns(self, now_ns: int) -> int:
        """Run time of the motion at `now_ns`; what the pulses slipped is not counted."""
        return self._run_ns(now_ns, self._output.status())

    def motion_ns(self, now_ns: int) -> int:
        """How far the motion has come, in the time of its plan."""
        return max(0, self._motion.motion_ns(self.run_ns(now_ns)))

    def pause(self, now_ns: int) -> None:
        """Begin to slow down along the path."""
        self._note_pace(self._motion.pause(self.run_ns(now_ns)))

    def resume(self, now_ns: int) -> None:
        """Begin to go on."""
        self._note_pace(self._motion.resume(self.run_ns(now_ns)))

    def cancel(self, now_ns: int) -> None:
        """Slow down along the path, and drop the rest of it."""
        self._note_pace(self._motion.cancel(self.run_ns(now_ns)))

    def feed(self, now_ns: int) -> None:
        """Queue what is due within the look-ahead. Raises MotionError, PulseFault."""
        seen = self._output.status()
        chunk = self._motion.take(self._run_ns(now_ns, seen) + ns(LOOKAHEAD_S))
        if len(chunk.ticks):
            self._take_over_slip(seen)
            ticks = Ticks(chunk.ticks.due_ns + self._start_ns, chunk.ticks.steps)
            if self._feedback is not None:
                ticks = self._feedback.trim(ticks, now_ns)
            self._check_awake(now_ns)
            self._output.push(ticks)
        self._note(chunk.reached, self._start_ns + self._slip_ns(seen))

    def _note_pace(self, pace: Pace) -> None:
        begins_ns = pace.run_ns + self._start_ns + self._slip_ns(self._output.status())
        self._journal.pace(begins_ns, pace.rate, pace.goal, pace.ramp_ns / NS_PER_S)

    def _check_awake(self, now_ns: int) -> None:
        """The pulses ran dry while we hung, after the control loop had looked: do not go on."""
        hung_ns = self._clock.now_ns() - now_ns
        if hung_ns > self._heartbeat_ns:
            raise PulseFault(f"no heartbeat: the controller hung for {hung_ns / NS_PER_S:.1f} s")

    def _note(self, reached: Reached, offset_ns: int) -> None:
        rows = zip(
            reached.t_ns.tolist(),
            reached.number.tolist(),
            reached.position_m.tolist(),
            reached.counts.tolist(),
            strict=True,
        )
        for t_ns, number, position_m, counts in rows:
            if number >= 0:
                self.target_m = tuple(position_m)
                self._journal.target(t_ns + offset_ns, number, self.target_m, tuple(counts))

    def _run_ns(self, now_ns: int, seen: OutputStatus) -> int:
        return now_ns - self._start_ns - self._slip_ns(seen)

    def _take_over_slip(self, seen: OutputStatus) -> None:
        """A player that ran dry starts afresh: what it was late by is now part of the plan."""
        if _is_still(seen):
            self._start_ns += seen.slip_ns - self._slip_before_ns
            self._slip_before_ns = seen.slip_ns

    def _slip_ns(self, seen: OutputStatus) -> int:
        return seen.slip_ns - self._slip_before_ns


def _is_still(seen: OutputStatus) -> bool:
    return seen.state is OutputState.READY and seen.queued == 0
