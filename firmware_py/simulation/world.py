"""A robot made of the chain of models/chain, moved by simulated drives, seen by fake sensors.

Does not model: dynamics between the chain's own effects, collisions, or cables. The arms
start against their stops, at the home angles (with home switches: hanging below them);
releasing the drives puts them back there, as a careful operator would.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from firmware_py.robot_file import RobotFile
from foundation.clock import NS_PER_S, ns
from models.chain import OnlineChain
from models.robot import AXES, FloatArray

CountsAt = Callable[[int], tuple[float, float, float]]
"""Where the drives have brought the arms at a time, in counts."""

GRID_S = 0.002
"""Step of the chain: a tenth of the shortest timing budget, so that averages are smooth."""
MEMORY_S = 5.0
DROOP_RAD = 0.2
AVERAGED = 8
"""Points over which the light of one sample is averaged."""


@dataclass(frozen=True, slots=True)
class Truth:
    """Where the simulated robot really is."""

    t_ns: int
    position_m: tuple[float, float, float]
    angles_rad: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class _Sample:
    t_ns: int
    position_m: FloatArray
    angles_rad: FloatArray
    ranges_m: FloatArray


class SimulatedRobot:
    """Advances the chain lazily, whenever somebody looks at it."""

    def __init__(self, robot: RobotFile, counts_at: CountsAt, now_ns: Callable[[], int]):
        self._robot = robot
        self._now_ns = now_ns
        start_ns = now_ns()
        self._counts_at = counts_at
        self._home_rad = np.deg2rad(robot.homing.angle_deg)
        self._rest_steps = (self._home_rad + self.droop_rad(robot)) / robot.drive.rad_per_step
        self._lock = threading.Lock()
        self._start_ns = start_ns
        self._samples: deque[_Sample] = deque(maxlen=round(MEMORY_S / GRID_S))
        self._next_ns = start_ns
        self._put(np.zeros(3))

    def put_to_stops(self, t_ns: int) -> None:
        """The simulated operator puts the arms against their stops; the drives must be released."""
        with self._lock:
            self._advance(t_ns)
            self._put(np.asarray(self._counts_at(t_ns), dtype=np.float64))

    def _put(self, counts: FloatArray) -> None:
        self._zero_steps = self._rest_steps - counts
        self._chain = OnlineChain(self._robot, self._robot.as_built.effects)

    def distance_m(self, axis: str, start_ns: int, end_ns: int) -> float:
        """Distance a sensor on `axis` sees on average from `start_ns` to `end_ns` [m]."""
        with self._lock:
            self._advance(end_ns)
            samples = self._window(start_ns, end_ns)
        column = AXES.index(axis)
        known_ns = np.array([sample.t_ns for sample in samples])
        ranges_m = np.array([sample.ranges_m[column] for sample in samples])
        at_ns = np.linspace(start_ns, end_ns, AVERAGED)
        return float(np.interp(at_ns, known_ns, ranges_m).mean())

    def switch_pressed(self, motor: int) -> bool:
        """Whether the home switch of an arm (0 to 2) is closed: it stands at home or above."""
        return bool(self.truth(self._now_ns()).angles_rad[motor] <= self._home_rad[motor])

    @staticmethod
    def droop_rad(robot: RobotFile) -> float:
        """How far below its home angle an arm rests: on its stop, or hanging under its switch."""
        return DROOP_RAD if robot.homing.method == "switch" else 0.0

    def truth(self, t_ns: int) -> Truth:
        """Position and arm angles at a time not further back than the memory (5 s)."""
        with self._lock:
            self._advance(t_ns)
            sample = self._window(t_ns, t_ns)[-1]
        position, angles = sample.position_m, sample.angles_rad
        return Truth(
            sample.t_ns,
            (float(position[0]), float(position[1]), float(position[2])),
            (float(angles[0]), float(angles[1]), float(angles[2])),
        )

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
        count = (until_ns - self._next_ns) // step_ns + 1
        if count <= 0:
            return
        times_ns = self._next_ns + step_ns * np.arange(count, dtype=np.int64)
        moved = np.array([self._counts_at(int(t)) for t in times_ns], dtype=np.float64)
        t_s = (times_ns - self._start_ns) / NS_PER_S
        out = self._chain.advance(t_s, moved + self._zero_steps)
        for index, t_ns in enumerate(times_ns):
            self._samples.append(
                _Sample(int(t_ns), out.position[index], out.theta[index], out.ranges[index])
            )
        self._next_ns = int(times_ns[-1]) + step_ns
