"""What a running job leaves behind: hands targets, edges, readings and events to the recorder.

A recorder that fails (full disk) is reported once and never stops the motion.
"""

from __future__ import annotations

import threading
from collections.abc import Iterable

from deltactl.drivers.ranging.contract import Reading
from deltactl.drivers.steps.contract import Counts, Ticks
from deltactl.firmware_py.controller.jobs.view import View
from deltactl.firmware_py.servo.loop import ServoSample
from deltactl.firmware_py.simulation.world import Truth
from deltactl.recording.writing.writer import RunRecorder

Note = tuple[int, str, str]


class Journal:
    """The recorder of the job that runs now, or nothing between jobs.

    Events that happen between jobs (power, e-stop) are kept and open the next recording.
    """

    def __init__(self) -> None:
        self._recorder: RunRecorder | None = None
        self._view: View | None = None
        self._waiting: list[Note] = []
        self._lock = threading.Lock()

    @property
    def path(self) -> str | None:
        """File being written."""
        return str(self._recorder.path) if self._recorder else None

    @property
    def failed(self) -> str:
        """Why nothing more is written; empty while all is well."""
        return self._recorder.failed if self._recorder else ""

    def open(self, recorder: RunRecorder, view: View | None = None) -> None:
        """Start writing to `recorder`, and beside it what viewers draw."""
        with self._lock:
            self._recorder, self._view = recorder, view
            waiting, self._waiting = self._waiting, []
        for note in waiting:
            recorder.event(*note)
            if view is not None:
                view.event(*note)

    def detach(self) -> RunRecorder | None:
        """Write to it no longer; whoever takes it closes it, as long as the disk may take."""
        with self._lock:
            recorder, self._recorder, self._view = self._recorder, None, None
        return recorder

    def close(self) -> None:
        """Finish the file."""
        recorder = self.detach()
        if recorder is not None:
            recorder.close()

    def event(self, t_ns: int, kind: str, text: str) -> None:
        """Note something that happened."""
        if self._recorder is not None:
            self._recorder.event(t_ns, kind, text)
            if (view := self._view) is not None:
                view.event(t_ns, kind, text)
        else:
            self._waiting = [*self._waiting[-99:], (t_ns, kind, text)]

    def sent(self, ticks: Ticks) -> None:
        """Edges really sent."""
        if self._recorder is not None and len(ticks):
            self._recorder.edges(ticks.due_ns, ticks.steps)

    def commanded(self, t_ns: int, counts: Counts) -> None:
        """Record commanded counts of the motors."""
        if self._recorder is not None:
            self._recorder.commanded(t_ns, counts)
            if (view := self._view) is not None:
                view.counts(t_ns, counts)

    def target(
        self, t_ns: int, index: int, position_m: tuple[float, float, float], counts: Counts
    ) -> None:
        """A target of the path, at the time it is due."""
        if self._recorder is not None:
            self._recorder.target(t_ns, index, position_m, counts)
            if (view := self._view) is not None:
                view.target(t_ns, position_m)

    def pace(self, t_ns: int, rate: float, goal: float, ramp_s: float) -> None:
        """The path is followed at another pace from there on."""
        if self._recorder is not None:
            self._recorder.pace(t_ns, rate, goal, ramp_s)

    def reading(self, reading: Reading) -> None:
        """A sample of a distance sensor."""
        if self._recorder is not None:
            self._recorder.reading(reading)
            if (view := self._view) is not None:
                view.reading(reading)

    def servo(self, samples: Iterable[ServoSample]) -> None:
        """What the servos' loop did."""
        if self._recorder is not None:
            for sample in samples:
                self._recorder.servo(sample)

    def truth(self, truth: Truth) -> None:
        """Where the simulated robot really is."""
        if self._recorder is not None:
            self._recorder.truth(truth.t_ns, truth.position_m, truth.angles_rad)
