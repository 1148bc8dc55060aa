"""The ranging loop: reads the three sensors at their rate and hands every reading on."""

from __future__ import annotations

from collections.abc import Callable

from deltactl.drivers.ranging.contract import Gate, RangingSensors, Reading
from deltactl.firmware_py.controller.contract import SensorStatus
from deltactl.foundation.clock import NS_PER_S, Clock, Task, TaskHandle
from deltactl.models.robot import AXES

POLLS_PER_SAMPLE = 2
"""A sensor's own clock drifts against ours: polled once a period, samples would be missed."""
OLD_S = 1.0
"""A reading so old was taken before somebody stopped reading: it is no sign of health."""


class RangingLoop:
    """Polls the sensors; keeps the newest reading of each for status and plausibility."""

    def __init__(
        self,
        sensors: RangingSensors,
        clock: Clock,
        rate_hz: float,
        on_reading: Callable[[Reading], None],
        on_event: Callable[[str], None] = lambda text: None,
    ):
        self._sensors = sensors
        self._clock = clock
        self._period_ns = round(NS_PER_S / (POLLS_PER_SAMPLE * rate_hz))
        self._on_reading = on_reading
        self._on_event = on_event
        self._task: TaskHandle | None = None
        self.latest: dict[str, Reading] = {}
        self.rounds = 0

    def start(self, on_error: Callable[[BaseException], None]) -> None:
        """Once stopped, poll from now on, until `stop` or an error, which `on_error` hears of."""
        self._task = self._clock.start("ranging", self.task(), on_error)

    def stop(self) -> None:
        """Poll no more."""
        if self._task is not None:
            self._task.stop()
            self._task = None

    @property
    def started(self) -> bool:
        """Whether it was started, and not stopped since; it may have died of an error."""
        return self._task is not None

    @property
    def alive(self) -> bool:
        """Whether it goes round."""
        return self._task is not None and not self._task.done

    def task(self) -> Task:
        """Poll for ever; a late poll moves the next one, it is never made up for."""
        due_ns = self._clock.now_ns()
        while True:
            for reading in self._sensors.poll():
                self.latest[reading.axis] = reading
                self._on_reading(reading)
            for text in self._sensors.take_events():
                self._on_event(text)
            self.rounds += 1
            due_ns = max(due_ns + self._period_ns, self._clock.now_ns())
            yield due_ns

    def good_readings(self, since_ns: int) -> list[Reading]:
        """The newest reading of each axis, where it is good and was taken since then."""
        newest = (self.latest.get(axis) for axis in AXES)
        return [
            one
            for one in newest
            if one is not None and one.gate is Gate.GOOD and one.t_ns >= since_ns
        ]

    def status(self, blind: Callable[[str], str] = lambda axis: "") -> tuple[SensorStatus, ...]:
        """What each sensor there is says now; one that is 'ok' for its driver may yet be blind."""
        health = self._sensors.health()
        for axis in AXES:
            if health.get(axis) == "ok" and (said := blind(axis)):
                health[axis] = said
        return tuple(self._status_of(axis, health[axis]) for axis in AXES if axis in health)

    def _status_of(self, axis: str, health: str) -> SensorStatus:
        reading = self.latest.get(axis)
        if reading is None:
            return SensorStatus(axis, None, None, "none", None, health)
        age_s = (self._clock.now_ns() - reading.t_ns) / NS_PER_S
        if health == "ok" and age_s > OLD_S:
            health = f"not read for {age_s:.0f} s"
        return SensorStatus(
            axis, reading.distance_m, age_s, reading.gate.value, reading.signal_mcps, health
        )
