"""The feedback on a bench of its own: planned ticks, arms that may slip, readings that may lie.

Closes the loop without controller, bus or files, so that a run of half a minute takes a moment.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache

import numpy as np

from deltactl.drivers.ranging.contract import Gate, Reading
from deltactl.drivers.steps.contract import Ticks
from deltactl.firmware_py.feedback.feedback import Feedback
from deltactl.firmware_py.feedback.settings import FeedbackSettings
from deltactl.firmware_py.job_file import JobFile
from deltactl.firmware_py.job_targets import kinematics_of
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.planner.plan import home_counts, make_plan
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.clock import NS_PER_S
from deltactl.models.linkage import Linkage, forward
from deltactl.models.robot import AXES, FloatArray
from deltactl.repair.played import played

BLOCK_NS = 100_000_000
READINGS_IN_BLOCK = 5
ROBOT = load_robot(CONFIG_FOLDER / "zhao-2023.yaml")
NOISE_M = 0.0015
Lie = Callable[[str, float, float], float]
"""Axis, time [s] and true range [m] -> what the sensor says; NaN: nothing at all."""


def honest(axis: str, t_s: float, range_m: float) -> float:
    """What is true."""
    return range_m


@cache
def planned(turns: int) -> Ticks:
    """A circle of 6 cm at T_PWM 6 ms, from home on."""
    job = JobFile.model_validate(
        {
            "name": "circle",
            "robot": "zhao-2023.yaml",
            "path": {"shape": "circle", "centre_m": (0.0, 0.0, -0.45), "radius_m": 0.06,
                     "turns": turns},
            "timing": {"mode": "together", "t_pwm_s": 0.006},
            "inverse_kinematics": {"kind": "geometry"},
        }
    )  # fmt: skip
    path = played(make_plan(job, ROBOT, kinematics_of(job, ROBOT, None)))
    steps = np.diff(path.counts, axis=0).astype(np.int8)
    return Ticks(np.rint(path.due_s[1:] * NS_PER_S).astype(np.int64), steps)


@dataclass
class Loop:
    """After `run`: times (n,) [s], and how far the platform is from its plan, (n,) [m]."""

    settings: FeedbackSettings = field(default_factory=FeedbackSettings)
    latency_s: float = 0.0
    says: Lie = honest
    losses: tuple[tuple[int, int, float], ...] = ()
    """Motor (0 to 2), steps that it loses, and when [s]."""
    seed: int = 1
    on: bool = True

    def run(self, turns: int = 1) -> tuple[FloatArray, FloatArray]:
        """Play the circle."""
        ticks, counts = planned(turns), home_counts(ROBOT)
        self.feedback = Feedback(ROBOT, self.settings, counts, 0)
        self._rng = np.random.default_rng(self.seed)
        self._due, self._made = [np.zeros(1, np.int64)], [np.array([counts], dtype=np.int64)]
        wanted = np.array(counts) + np.cumsum(ticks.steps, axis=0, dtype=np.int64)
        t_s, off_m = [], []
        for start_ns in range(0, int(ticks.due_ns[-1]), BLOCK_NS):
            end_ns = start_ns + BLOCK_NS
            mine = (ticks.due_ns >= start_ns) & (ticks.due_ns < end_ns)
            block = Ticks(ticks.due_ns[mine], ticks.steps[mine])
            self._send(self.feedback.trim(block, start_ns) if self.on else block)
            self._read(start_ns)
            row = max(0, int(np.searchsorted(ticks.due_ns, end_ns)) - 1)
            place = self._position_m(self._true(np.array([end_ns]))[0])
            t_s.append(end_ns / NS_PER_S)
            off_m.append(float(np.linalg.norm(place - self._position_m(wanted[row]))))
        return np.array(t_s), np.array(off_m)

    def _send(self, ticks: Ticks) -> None:
        self.feedback.sent(ticks)
        if len(ticks):
            self._due.append(ticks.due_ns)
            self._made.append(self._made[-1][-1] + np.cumsum(ticks.steps, axis=0, dtype=np.int64))

    def _true(self, t_ns: np.ndarray) -> FloatArray:
        """Where the arms really are, in counts, (n, 3)."""
        due, made = np.concatenate(self._due[-8:]), np.concatenate(self._made[-8:])
        counts = made[np.maximum(np.searchsorted(due, t_ns, side="right") - 1, 0)].astype(float)
        for motor, steps, when_s in self.losses:
            counts[:, motor] -= steps * (t_ns > when_s * NS_PER_S)
        return counts

    def _position_m(self, counts: FloatArray) -> FloatArray:
        linkage, step_rad = Linkage.of(ROBOT.geometry), ROBOT.drive.rad_per_step
        return forward(linkage, np.asarray(counts) * step_rad).position_m

    def _read(self, start_ns: int) -> None:
        assert ROBOT.sensors is not None
        times = start_ns + np.arange(READINGS_IN_BLOCK) * (BLOCK_NS // READINGS_IN_BLOCK)
        seen_m = self._position_m(self._true(times - round(self.latency_s * NS_PER_S)))
        ranges_m = ROBOT.sensors.offsets_m + seen_m @ ROBOT.sensors.axes.T
        for row, t_ns in enumerate(times.tolist()):
            for column, axis in enumerate(AXES):
                true_m = float(ranges_m[row, column]) + float(self._rng.normal(0.0, NOISE_M))
                said_m = self.says(axis, t_ns / NS_PER_S, true_m)
                if np.isfinite(said_m):
                    self.feedback.reading(
                        Reading(axis, t_ns, said_m, 0, 9, 10.0, 0.1, NOISE_M, row, Gate.GOOD)
                    )


def rms_m(off_m: FloatArray) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(off_m**2)))
