"""What a controller sees of its machine while it runs: noted, and looked through for lost steps."""

from __future__ import annotations

from deltactl.drivers.ranging.contract import Reading
from deltactl.firmware_py.controller.jobs.journal import Journal
from deltactl.firmware_py.controller.sensing.sight import Blindness, Sight
from deltactl.firmware_py.controller.sensing.step_watch import StepLoss, StepWatch
from deltactl.firmware_py.feedback.feedback import Feedback
from deltactl.firmware_py.machine import Machine
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.clock import ns
from deltactl.models.robot import FloatArray

BORNE_OUT_S = 4.0
"""The feedback takes some seconds to be sure of what the watch sees at once."""


class Observer:
    """Hands everything to the journal, and what steppers did to the watch.

    A servo robot has encoders: it sees by itself when an arm does not follow.
    """

    def __init__(self, robot: RobotFile, machine: Machine, journal: Journal):
        self._machine = machine
        self._journal = journal
        self._watch = StepWatch(robot) if machine.servo is None else None
        self._sight = Sight(robot)
        self._seen: tuple[StepLoss, int] | None = None
        """A loss that the feedback has not borne out yet, and until when it may."""
        self.feedback: Feedback | None = None
        """Feedback of the job that runs now, if it has one."""

    def accept(self, robot: RobotFile) -> None:
        """Another robot file is in force; `restart` follows when the counters are set."""
        self.collect()
        self._watch = StepWatch(robot) if self._machine.servo is None else None
        self._sight = Sight(robot)
        self._sight.restart(self._machine.clock.now_ns())

    def collect(self) -> None:
        """Take what the output has done since the last call."""
        sent = self._machine.output.take_sent()
        self._journal.sent(sent)
        if self._watch is not None:
            self._watch.sent(sent)
        if self.feedback is not None:
            self.feedback.sent(sent)
        if self._machine.servo is not None:
            self._journal.servo(self._machine.servo.take_samples())
        elif self._machine.world is not None:
            self._machine.world.keep_up(self._machine.clock.now_ns())

    def note_truth(self, now_ns: int) -> None:
        """Where the simulated robot is; beside readings it is noted at their times instead."""
        unseen = self._machine.rig is None and self._journal.path is not None
        if unseen and self._machine.world is not None:
            self._journal.truth(self._machine.world.truth(now_ns))

    def restart(self, now_ns: int) -> None:
        """The counters were set: what was before says nothing about what comes."""
        self.collect()
        if self._watch is not None:
            self._watch.reset(self._machine.output.status().counts, now_ns)

    def homed(self, now_ns: int, ranges_m: FloatArray) -> None:
        """The counters were set at home, where the sensors said this: (3,), NaN where nothing."""
        self.collect()
        if self._watch is not None:
            self._watch.homed(self._machine.output.status().counts, now_ns, ranges_m)

    def reading(self, reading: Reading) -> None:
        """A sample of a distance sensor, from the ranging loop."""
        self._journal.reading(reading)
        self._sight.reading(reading)
        if self._watch is not None:
            self._watch.reading(reading)
        if self.feedback is not None:
            self.feedback.reading(reading)
        if self._machine.world is not None and reading.axis == "x":
            self._journal.truth(self._machine.world.truth(reading.t_ns))

    def sensors_started(self, now_ns: int) -> None:
        """The ranging loop begins."""
        self._sight.restart(now_ns)

    def blind(self, bears_pauses: bool = False) -> Blindness | None:
        """Whether the arms are not seen; a servo robot's encoders see them anyway."""
        if self._machine.servo is not None:
            return None
        sensors, now_ns = self._machine.sensors, self._machine.clock.now_ns()
        return self._sight.blind(now_ns, sensors.health, bears_pauses)

    def blindness_of(self, axis: str) -> str:
        """What is to be said of one sensor's sight; empty while it sees."""
        return self._sight.says_of(axis, self._machine.clock.now_ns())

    def lost_steps(self, now_ns: int) -> StepLoss | None:
        """Steps that the sensors show to be lost, reported once."""
        loss = self._watch.look(now_ns) if self._watch is not None else None
        if loss is not None and self._watch is not None:
            self._watch.forgive()
        if self.feedback is None:
            return loss
        return self._borne_out(loss, self.feedback, now_ns)

    def _borne_out(self, loss: StepLoss | None, feedback: Feedback, now_ns: int) -> StepLoss | None:
        """A loss once the feedback corrects it: that tells late readings and liars from arms."""
        if loss is not None and loss.motor:
            self._seen = loss, now_ns + ns(BORNE_OUT_S)
        if self._seen is None:
            return None
        seen, until_ns = self._seen
        corrected = feedback.corrects(seen.motor)
        if corrected or now_ns > until_ns:
            self._seen = None
        return seen if corrected else None
