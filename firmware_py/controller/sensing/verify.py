"""Were steps lost? Home, run a job, go back to the home angles, and compare what the sensors see.

Any controller will do, also a daemon's client. The difference of the ranges, through the
linkage's derivatives at the home angles, becomes steps of each motor. Errors of the model and
offsets of the sensors cancel, since both looks are at one pose; noise is averaged.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from deltactl.firmware_py.controller.contract import JobResult, RobotController, Status
from deltactl.firmware_py.controller.sensing.determined import range_slopes_m
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.errors import MotionError, NotReady
from deltactl.models.robot import AXES, FloatArray

LOOK_S = 3.0
LONGER = 5  # times as long, where a busy computer brings readings late
EVERY_S = 0.03
"""Longer than a sensor's period, so that every look brings a new sample."""
SIGMAS = 4.0
LEAST_STEPS = 10.0
"""Fewer are not called lost: play and the drives' own hysteresis look the same."""

Triple = tuple[float, float, float]
Follow = Callable[[int], JobResult]
"""Waits for the end of a job; returns how it ended."""


@dataclass(frozen=True, slots=True)
class Verification:
    """Steps that each motor is behind its counter after the run, and how sure that is."""

    steps: Triple
    sigma_steps: Triple

    @property
    def lost(self) -> tuple[int, ...]:
        """Motors (1 to 3) that lost steps."""
        rows = enumerate(zip(self.steps, self.sigma_steps, strict=True), start=1)
        return tuple(n for n, (found, sigma) in rows if abs(found) > self._limit(sigma))

    def says(self) -> str:
        """One line."""
        figures = ", ".join(
            f"motor{n} {found:+.0f} +- {sigma:.0f}"
            for n, (found, sigma) in enumerate(
                zip(self.steps, self.sigma_steps, strict=True), start=1
            )
        )
        if not self.lost:
            return f"no steps lost (steps behind the counters: {figures})"
        motors = " and ".join(f"motor{n}" for n in self.lost)
        return (
            f"steps lost by {motors} (steps behind the counters: {figures}); find the cause, put"
            " the arms against their stops, and home again"
        )

    @staticmethod
    def _limit(sigma: float) -> float:
        return max(LEAST_STEPS, SIGMAS * sigma)


def verify(
    controller: RobotController,
    robot: RobotFile,
    job: Path,
    follow: Follow,
    sleep: Callable[[float], None],
) -> Verification:
    """Home, look, run, home, look. The robot must be on, with its arms at home or homed.

    Raises NotReady when a sensor has no good readings, MotionError when the job does not end
    by itself, and what the controller raises.
    """
    if robot.sensors is None:
        raise NotReady(f"robot '{robot.name}' has no sensors; lost steps cannot be seen")
    controller.home()
    before_m, before_sigma_m = _look(controller, sleep)
    result = follow(controller.submit(job))
    if result.outcome != "done":
        ended = f"{result.outcome}: {result.why}" if result.why else result.outcome
        raise MotionError(f"nothing can be said about lost steps, as the job ended as {ended}")
    controller.home()
    after_m, after_sigma_m = _look(controller, sleep)
    to_steps = (
        np.linalg.inv(range_slopes_m(robot, np.deg2rad(robot.homing.angle_deg)))
        / -robot.drive.rad_per_step
    )
    moved_m = after_m - before_m
    sigma_m = np.hypot(before_sigma_m, after_sigma_m)
    return Verification(
        _triple(to_steps @ moved_m),
        _triple(np.sqrt(to_steps**2 @ sigma_m**2)),
    )


def _look(
    controller: RobotController, sleep: Callable[[float], None]
) -> tuple[FloatArray, FloatArray]:
    """Mean of the good ranges of each axis [m], and its standard error. Raises NotReady."""
    seen_m = good_ranges_m(controller.status, sleep, LOOK_S)
    means_m = np.array([np.mean(values) for values in seen_m.values()])
    sigmas_m = np.array([np.std(v, ddof=1) / np.sqrt(len(v)) for v in seen_m.values()])
    return means_m, sigmas_m


def good_ranges_m(
    status: Callable[[], Status], sleep: Callable[[float], None], look_s: float
) -> dict[str, list[float]]:
    """Good ranges of each axis [m] within a time, or up to `LONGER` times it where a busy computer
    brings them late. Raises NotReady where they are too few.
    """
    seen_m: dict[str, list[float]] = {axis: [] for axis in AXES}
    looks = round(look_s / EVERY_S)
    for number in range(LONGER * looks):
        if number >= looks and min(map(len, seen_m.values())) >= looks / 4:
            break
        sleep(EVERY_S)
        now = status()
        for sensor in now.sensors:
            fresh = sensor.age_s is not None and sensor.age_s < 2.0 * EVERY_S
            if fresh and sensor.gate == "good" and sensor.distance_m is not None:
                seen_m[sensor.axis].append(sensor.distance_m)
    if blind := [axis for axis, values in seen_m.items() if len(values) < looks / 4]:
        which = f"{'sensors' if len(blind) > 1 else 'sensor'} {', '.join(blind)}"
        busy = "; simulated sensors are late on a busy computer" if now.simulated else ""
        raise NotReady(f"too few good readings of {which}; see 'deltactl status sensors'{busy}")
    return seen_m


def _triple(values: FloatArray) -> Triple:
    first, second, third = values.tolist()
    return first, second, third
