"""A robot made of the chain of models/chain, moved by simulated drives, seen by fake sensors.

Does not model: dynamics between the chain's own effects, collisions, or cables. The arms
start against their stops, at the home angles (with home switches: hanging below them);
releasing the drives puts them back there, and so does homing from anywhere else, as a careful
operator would.

The simulated robot may be described in a file apart from the robot file: recordings contain the
robot file, so its contents are known to whoever diagnoses them; this file is in none.
"""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.clock import NS_PER_S, ns
from deltactl.foundation.errors import MissingFile
from deltactl.foundation.strict_yaml import Document, StrictModel
from deltactl.models.chain import OnlineChain
from deltactl.models.chain.active import of_entries
from deltactl.models.effects.joint_friction import without_swing
from deltactl.models.linkage import Linkage
from deltactl.models.linkage.scalar import forward_one
from deltactl.models.linkage.vectors import Vector
from deltactl.models.robot import ARMS, AXES, EffectEntry, FloatArray

Effects = tuple[EffectEntry, ...]


class AsBuiltFile(StrictModel):
    """All the effects that the simulated robot has; the robot file has the accepted ones."""

    effects: Effects


class HiddenEffects:
    """Such a file, read again whenever the arms are put against their stops."""

    def __init__(self, path: Path):
        self._path = path

    def effects(self) -> Effects | None:
        """None while there is no such file. Raises ConfigError."""
        try:
            found = Document.read(self._path).check(AsBuiltFile).effects
        except MissingFile:
            return None
        of_entries(found)
        return found


def nothing_apart() -> Effects | None:
    """For a simulated robot that has no such file."""
    return None


class NominalRobot:
    """What models/chain gives without effects, of counts: position, arm angles, and ranges, which
    are NaN without sensors."""

    def __init__(self, robot: RobotFile):
        self._linkage = Linkage.of(robot.geometry)
        self._step_rad = robot.drive.rad_per_step
        sensors = robot.sensors
        self._rows = [(math.nan, 0.0, 0.0, 0.0)] * ARMS
        if sensors is not None:
            rows = zip(sensors.offsets_m.tolist(), sensors.axes.tolist(), strict=True)
            self._rows = [(offset, *axis) for offset, axis in rows]
        self._at: Vector | None = None

    def at(self, steps: Vector) -> tuple[Vector, Vector, Vector]:
        """Platform [m], true arm angles [rad] and ranges [m] at commanded counts."""
        if steps != self._at:  # the arms rest most of the time
            self._at, self._found = steps, self._find(steps)
        return self._found

    def _find(self, steps: Vector) -> tuple[Vector, Vector, Vector]:
        first, second, third = (count * self._step_rad for count in steps)
        x, y, z = position_m = forward_one(self._linkage, (first, second, third))
        ranges = [offset + a * x + b * y + c * z for offset, a, b, c in self._rows]
        return position_m, (first, second, third), (ranges[0], ranges[1], ranges[2])


CountsAt = Callable[[int], tuple[float, float, float]]
"""Where the drives have brought the arms at a time, in counts."""

GRID_S = 0.002
"""Step of the chain: a tenth of the shortest timing budget, so that averages are smooth."""
MEMORY_S = 5.0
DROOP_RAD = 0.2
RESTING_RAD = 2e-3
"""So near its stop, a tenth of a degree, an arm lies against it."""
MOST_AT_ONCE = 500
"""Samples in one block: nobody may have looked for a night."""
UNWATCHED_S = 1.0
"""After this long without a look it is worked out all the same: an hour at once takes 13 s."""
AVERAGED = 8
"""Points over which the light of one sample is averaged."""


@dataclass(frozen=True, slots=True)
class Truth:
    """Where the simulated robot really is."""

    t_ns: int
    position_m: tuple[float, float, float]
    angles_rad: tuple[float, float, float]


class _Sample(NamedTuple):
    t_ns: int
    position_m: Vector
    angles_rad: Vector
    ranges_m: Vector


class SimulatedRobot:
    """Advances the chain lazily, whenever somebody looks at it."""

    def __init__(
        self,
        robot: RobotFile,
        counts_at: CountsAt,
        now_ns: Callable[[], int],
        apart: Callable[[], Effects | None] = nothing_apart,
    ):
        """apart: its true effects, if they are not in the robot file."""
        self._robot = robot
        self._apart = apart
        self._now_ns = now_ns
        start_ns = now_ns()
        self._counts_at = counts_at
        self._home_rad = np.deg2rad(robot.homing.angle_deg)
        self._rest_steps = (self._home_rad + self.droop_rad(robot)) / robot.drive.rad_per_step
        self._lock = threading.Lock()
        self._start_ns = start_ns
        self._kept = round(MEMORY_S / GRID_S)
        self._samples: deque[_Sample] = deque(maxlen=self._kept)
        self._next_ns = start_ns
        self._put(np.zeros(3))

    def put_to_stops(self, t_ns: int) -> None:
        """The simulated operator puts the arms against their stops; the drives must be released."""
        with self._lock:
            self._advance(t_ns)
            self._put(np.asarray(self._counts_at(t_ns), dtype=np.float64))

    def rests(self, t_ns: int) -> bool:
        """Whether the arms are where `put_to_stops` would put them, and it was not built anew."""
        if self._effects() != self._built:
            return False
        with self._lock:
            self._advance(t_ns)
            counts = np.asarray(self._counts_at(t_ns), dtype=np.float64)
            off_steps = counts + self._zero_steps - self._rest_steps
        return bool(np.abs(off_steps).max() * self._robot.drive.rad_per_step < RESTING_RAD)

    def accepted_anew(self, robot: RobotFile, t_ns: int) -> None:
        """Another robot file is in force; the drives must be released."""
        with self._lock:
            self._advance(t_ns)
            self._robot = robot
            self._home_rad = np.deg2rad(robot.homing.angle_deg)
            self._rest_steps = (self._home_rad + self.droop_rad(robot)) / robot.drive.rad_per_step
            self._put(np.asarray(self._counts_at(t_ns), dtype=np.float64))

    def _put(self, counts: FloatArray) -> None:
        self._zero_steps = self._zero_at(counts)
        robot, self._built = self._robot, self._effects()
        real = tuple(without_swing(entry) for entry in self._built)
        self._chain = OnlineChain(robot.model_copy(update={"effects": ()}), real)
        self._nominal = None if real else NominalRobot(robot)

    def _effects(self) -> Effects:
        apart = self._apart()
        return self._robot.effects_as_built if apart is None else apart

    def _zero_at(self, counts: FloatArray) -> FloatArray:
        """Where count 0 is, in steps, while the arms rest at these counts."""
        return self._rest_steps - counts

    def distance_m(self, axis: str, start_ns: int, end_ns: int) -> float:
        """Distance a sensor on `axis` sees on average from `start_ns` to `end_ns` [m]."""
        with self._lock:
            self._advance(end_ns)
            samples = self._window(start_ns, end_ns)
        column = AXES.index(axis)
        return _mean(
            [(sample.t_ns, sample.ranges_m[column]) for sample in samples], start_ns, end_ns
        )

    def keep_up(self, now_ns: int) -> None:
        """Work out what nobody has looked at, now and then; without effects nothing needs it."""
        if self._nominal is None and now_ns - self._next_ns > ns(UNWATCHED_S):
            with self._lock:
                self._advance(now_ns)

    def above_home_rad(self, motor: int) -> float:
        """How far an arm (0 to 2) is above its home angle, where its switch closes [rad]."""
        return float(self._home_rad[motor]) - self.truth(self._now_ns()).angles_rad[motor]

    @staticmethod
    def droop_rad(robot: RobotFile) -> float:
        """How far below its home angle an arm rests: on its stop, or hanging under its switch."""
        return DROOP_RAD if robot.homing.method == "switch" else 0.0

    def truth(self, t_ns: int) -> Truth:
        """Position and arm angles at a time not further back than the memory (5 s)."""
        with self._lock:
            self._advance(t_ns)
            sample = self._window(t_ns, t_ns)[-1]
        return Truth(sample.t_ns, sample.position_m, sample.angles_rad)

    def _window(self, start_ns: int, end_ns: int) -> list[_Sample]:
        """Samples within the window and the ones next to it; the oldest if it is forgotten."""
        newest_first: list[_Sample] = []
        for sample in reversed(self._samples):
            if newest_first and newest_first[-1].t_ns < start_ns:
                break
            if sample.t_ns > end_ns and newest_first:
                newest_first.clear()
            newest_first.append(sample)
        return newest_first[::-1]

    def _advance(self, until_ns: int) -> None:
        """Up to a time, and if that is not reached yet, up to now: fewer, larger blocks."""
        if until_ns < self._next_ns:
            return
        until_ns = max(until_ns, self._now_ns())
        step_ns = ns(GRID_S)
        if self._nominal is not None:  # nothing to remember: leave out what would be forgotten
            ahead = (until_ns - self._next_ns) // step_ns - self._kept
            self._next_ns += max(0, ahead) * step_ns
        while self._next_ns <= until_ns:
            count = (until_ns - self._next_ns) // step_ns + 1
            self._advance_by(min(count, MOST_AT_ONCE), step_ns)

    def _advance_by(self, count: int, step_ns: int) -> None:
        times_ns = range(self._next_ns, self._next_ns + count * step_ns, step_ns)
        counts = [self._counts_at(t_ns) for t_ns in times_ns]
        simulate = self._by_chain if self._nominal is None else self._nominally
        self._samples.extend(simulate(times_ns, counts))
        self._next_ns = times_ns[-1] + step_ns

    def _by_chain(self, times_ns: range, counts: list[Vector]) -> Iterator[_Sample]:
        t_s = (np.array(times_ns, dtype=np.int64) - self._start_ns) / NS_PER_S
        out = self._chain.advance(t_s, np.array(counts, dtype=np.float64) + self._zero_steps)
        parts = (out.position.tolist(), out.theta.tolist(), out.ranges.tolist())
        for t_ns, position_m, angles_rad, ranges_m in zip(times_ns, *parts, strict=True):
            yield _Sample(t_ns, tuple(position_m), tuple(angles_rad), tuple(ranges_m))

    def _nominally(self, times_ns: range, counts: list[Vector]) -> Iterator[_Sample]:
        """Without effects there is nothing to remember, and numpy costs more than it saves."""
        assert self._nominal is not None
        zero = self._zero_steps.tolist()
        for t_ns, (first, second, third) in zip(times_ns, counts, strict=True):
            steps = (first + zero[0], second + zero[1], third + zero[2])
            yield _Sample(t_ns, *self._nominal.at(steps))


def _mean(known: list[tuple[int, float]], start_ns: int, end_ns: int) -> float:
    """Mean of a course over evenly spaced times, straight between its points, level beyond."""
    total, index, last = 0.0, 0, len(known) - 1
    for number in range(AVERAGED):
        at_ns = start_ns + (end_ns - start_ns) * number / (AVERAGED - 1)
        while index < last and known[index + 1][0] <= at_ns:
            index += 1
        t_ns, value = known[index]
        if index < last and at_ns > t_ns:
            then_ns, then = known[index + 1]
            value += (then - value) * (at_ns - t_ns) / (then_ns - t_ns)
        total += value
    return total / AVERAGED
