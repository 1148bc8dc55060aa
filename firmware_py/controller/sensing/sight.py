"""Whether the robot sees its arms: good readings that determine them, and no older than `BLIND_S`.

A sensor's own state says that it ranges; this says that what it says can be used. A status
that refuses every sample, a sensor that repeats itself, an I2C call that does not come back:
all of them end in readings that grow old.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from deltactl.drivers.ranging.contract import Gate, Reading
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.clock import NS_PER_S, ns
from deltactl.models.robot import AXES

BLIND_S = 0.5
PERIODS = 3
"""A sensor that ranges slowly may take so many periods."""
PAUSE_S = 0.1
"""Nobody looked for longer: the computer was busy, and so was the loop that reads the sensors.
For as long again it may catch up: meanwhile the pause does not count into the age of readings. How
long a pause may be is for the heartbeat to say."""


@dataclass(frozen=True, slots=True)
class Blindness:
    """Which sensors have said nothing good, since when, and what they say instead."""

    axes: tuple[str, ...]
    since_ns: int
    seconds: float
    instead: tuple[str, ...]

    def says(self) -> str:
        """One line, without a figure that changes."""
        named = " and ".join(
            f"{axis} ({said})" for axis, said in zip(self.axes, self.instead, strict=True)
        )
        return f"blind: no good reading of sensor {named} that would determine the arms"


class Sight:
    """Receives every reading, from any thread; asked by the control loop."""

    def __init__(self, robot: RobotFile):
        self._sensors = robot.sensors
        self._limit_ns = max(ns(BLIND_S), round(PERIODS * NS_PER_S / robot.ranging.rate_hz))
        self._good_ns: dict[str, int] = {}
        self._said: dict[str, str] = {}
        self._start_ns = 0
        self._looked_ns = self._woke_ns = self._paused_ns = 0

    def restart(self, now_ns: int) -> None:
        """The sensors have just been started: they have as long as any blindness may last."""
        self._start_ns = self._looked_ns = now_ns
        self._good_ns, self._said = {}, {}

    def reading(self, reading: Reading) -> None:
        """A sample of a sensor."""
        if reading.gate is Gate.GOOD:
            self._good_ns[reading.axis] = reading.t_ns
            self._said.pop(reading.axis, None)
        else:
            self._said[reading.axis] = f"refused: {reading.gate.value}"

    def blind(
        self, now_ns: int, health: Callable[[], dict[str, str]], bears_pauses: bool = False
    ) -> Blindness | None:
        """The blindness of now, or None. A robot without sensors never sees, and is not blind.

        health: what the driver says of each sensor, asked only in case of blindness.
        bears_pauses: for the loop that stops a run; it asks again and again.
        """
        if self._sensors is None:
            return None
        last_ns = [self._good_ns.get(axis, self._start_ns) for axis in AXES]
        age_ns = now_ns - min(last_ns)  # three angles need all three ranges
        paused_ns = self._pause_ns(now_ns) if bears_pauses else 0
        if age_ns <= self._limit_ns + paused_ns:
            return None
        since_ns = min(last_ns)
        # Whoever is about to follow is named too: one cause blinds all within a few polls.
        late = [now_ns - seen_ns > self._limit_ns // 2 for seen_ns in last_ns]
        axes = tuple(axis for axis, is_late in zip(AXES, late, strict=True) if is_late)
        drivers = health()
        instead = tuple(self._instead(axis, drivers.get(axis, "ok")) for axis in axes)
        return Blindness(axes, since_ns, age_ns / NS_PER_S, instead)

    def _pause_ns(self, now_ns: int) -> int:
        """For how long nobody looked, where that ended a moment ago; else 0."""
        if (unseen_ns := now_ns - self._looked_ns) > ns(PAUSE_S):
            self._woke_ns, self._paused_ns = now_ns, unseen_ns
        self._looked_ns = now_ns
        return self._paused_ns if now_ns - self._woke_ns < ns(PAUSE_S) else 0

    def says_of(self, axis: str, now_ns: int) -> str:
        """'blind for 3.2 s (refused: status)' of one sensor; empty while it sees."""
        age_ns = now_ns - self._good_ns.get(axis, self._start_ns)
        if age_ns <= self._limit_ns:
            return ""
        return f"blind for {age_ns / NS_PER_S:.1f} s ({self._said.get(axis, 'no new sample')})"

    def _instead(self, axis: str, health: str) -> str:
        """The driver's word first: it knows of wires and resets."""
        return self._said.get(axis, "no new sample") if health == "ok" else health
