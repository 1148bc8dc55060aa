"""What ends a motion at once, whoever asks for it: stops, faults, and loops that died."""

from __future__ import annotations

from deltactl.drivers.steps.contract import OutputStatus
from deltactl.firmware_py.controller.condition import Condition
from deltactl.firmware_py.controller.jobs.jobs import Jobs
from deltactl.firmware_py.controller.observer import Observer
from deltactl.firmware_py.controller.sensing.sight import Blindness
from deltactl.firmware_py.controller.states import Event, Happening, Request, State
from deltactl.firmware_py.machine import Machine
from deltactl.foundation.clock import Task
from deltactl.foundation.errors import NotReady

LATCHED = frozenset({State.STOPPED, State.FAULT})
STOP_REASONS = ("e-stop", "stop requested")
"""What the output says of a stop that somebody wanted."""

NO_HEARTBEAT = "no heartbeat"
BUSY = (
    "; this computer was too busy to simulate the robot in real time: end other programs, and close"
    " pages that show it"
)
"""What a missing heartbeat means where nothing but this computer can be the cause."""


class Emergency:
    """Stops the pulses first and then says why; what latched first stays the reason."""

    def __init__(self, machine: Machine, condition: Condition, jobs: Jobs, observer: Observer):
        self.lost = ""
        """Why only a new process can go on; empty while this one can."""
        self.stop_asked = False
        self.blind_latched = False
        self._machine = machine
        self._condition = condition
        self._jobs = jobs
        self._observer = observer

    def stop(self, reason: str) -> None:
        """Somebody asks; takes no lock before the pulses have ended."""
        self.stop_asked = True
        self._condition.turns += 1
        self._machine.output.stop(reason)
        with self._condition.lock:
            if self._condition.state in LATCHED:
                self._condition.note("stop", reason)
            else:
                self.halt(Request.STOP, reason)

    def fault(self, why: str) -> None:
        """The control loop found a reason."""
        self._machine.output.stop(why)
        self.halt(Happening.FAULT, why)

    def loop_died(self, error: BaseException) -> None:
        """By an error that nobody caught."""
        self._machine.output.stop(f"fault: {error}")
        with self._condition.lock:
            why = " ".join(str(error).split())
            if self._condition.state in LATCHED:
                self._condition.note("fault", why)
            else:
                self.halt(Happening.FAULT, why)

    def output_stopped(self, seen: OutputStatus) -> None:
        """By itself, or because it was asked to."""
        if self._condition.state in LATCHED:
            return
        wanted = self.stop_asked or any(word in seen.reason for word in STOP_REASONS)
        self.halt(Happening.ESTOP if wanted else Happening.FAULT, seen.reason)

    def output_lost(self, seen: OutputStatus) -> None:
        """Nobody watches the drives any more: release them from here; this process is done."""
        self.lost = seen.reason

        def task() -> Task:
            yield self._machine.clock.now_ns()
            self._condition.note("fault", f"{seen.reason}: {self._machine.release()}")

        self._machine.clock.start("releasing", task(), self.loop_died)

    def halt(self, event: Event, why: str) -> None:
        """The pulses have ended: so do homing and all jobs, and the state is latched."""
        self._condition.turns += 1
        self._observer.collect()
        if self._machine.simulated and NO_HEARTBEAT in why:
            why += BUSY
        fault = event is Happening.FAULT
        self._condition.note("fault" if fault else "stop", why)
        rule = self._condition.rule(event)
        if rule is not None and rule.ends:
            self._jobs.end_all("fault" if fault else "stopped", why)
        self._condition.go(event, why=why)

    def must_see(self, blind: Blindness | None) -> None:
        """A blindness that stopped the robot and is still there is a cause that has not gone."""
        if self.blind_latched and blind is not None:
            raise NotReady(
                f"cannot acknowledge: {blind.says()}; mend it, or 'deltactl power off' and"
                " 'deltactl acknowledge' to go on without a look"
            )
