"""Poses a second of inverse and forward kinematics on one core, and us of a single target.

Run: python benchmarks/costs/kinematics.py
Every figure is the best and the median of REPEATS runs over POSES random poses of the
robot's workspace. The process ties itself to one core where the system allows that.
"""

from __future__ import annotations

import os
import platform
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

import numpy as np

from deltactl.models.linkage import Linkage, Status, forward, inverse, inverse_one, jacobian
from deltactl.models.robot import FloatArray, Geometry

POSES = 1_000_000
TARGETS = 20_000
REPEATS = 9
REQUIRED_PER_S = 2e6

ROBOTS = {
    "zhao-2023": Geometry(
        base_radius_m=0.325, platform_radius_m=0.075, upper_arm_m=0.25, forearm_m=0.5
    ),
    "uzunovic-2013": Geometry(
        base_radius_m=0.04, platform_radius_m=0.03, upper_arm_m=0.04, forearm_m=0.068
    ),
}


def main() -> None:
    """Print the table."""
    print(f"{_machine()}; tied to one core: {'yes' if _one_core() else 'no'}")
    print(f"{POSES:,} poses, {REPEATS} repeats; million poses a second, best / median")
    for name, geometry in ROBOTS.items():
        linkage = Linkage.of(geometry)
        angles_rad, position_m = _workspace(linkage)
        for what, work in (
            ("inverse", lambda: inverse(linkage, position_m)),  # noqa: B023
            ("forward", lambda: forward(linkage, angles_rad)),  # noqa: B023
            ("jacobian", lambda: jacobian(linkage, angles_rad, position_m)),  # noqa: B023
        ):
            _print_rate(name, what, _durations_s(work))
        targets = [(x, y, z) for x, y, z in position_m[:TARGETS].tolist()]
        _print_single(name, _durations_s(lambda: _each(linkage, targets)))  # noqa: B023


def _workspace(linkage: Linkage) -> tuple[FloatArray, FloatArray]:
    """Random poses that the linkage can take: arm angles and platform positions, (POSES, 3)."""
    rng = np.random.default_rng(1)
    angles_rad = np.deg2rad(rng.uniform(-20.0, 110.0, (2 * POSES, 3)))
    position_m, status = forward(linkage, angles_rad)
    angles_rad, back = inverse(linkage, position_m)
    usable = (status == Status.OK) & (back == Status.OK)
    return angles_rad[usable][:POSES], position_m[usable][:POSES]


def _each(linkage: Linkage, targets: list[tuple[float, float, float]]) -> None:
    for x_m, y_m, z_m in targets:
        inverse_one(linkage, x_m, y_m, z_m)


def _durations_s(work: Callable[[], object]) -> list[float]:
    durations_s = []
    for _ in range(REPEATS + 1):
        start_s = time.perf_counter()
        work()
        durations_s.append(time.perf_counter() - start_s)
    return durations_s[1:]  # the first run warms the caches


def _print_rate(robot: str, what: str, durations_s: list[float]) -> None:
    best, middle = POSES / min(durations_s), POSES / median(durations_s)
    verdict = "" if what == "jacobian" or middle >= REQUIRED_PER_S else "  BELOW 2 MILLION"
    print(f"{robot:14} {what:9} {best / 1e6:6.1f} / {middle / 1e6:5.1f} M/s{verdict}")


def _print_single(robot: str, durations_s: list[float]) -> None:
    best, middle = min(durations_s) / TARGETS, median(durations_s) / TARGETS
    print(f"{robot:14} {'single':9} {best * 1e6:6.2f} / {middle * 1e6:5.2f} us a target")


def _one_core() -> bool:
    if not hasattr(os, "sched_setaffinity"):
        return False
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    return True


def _machine() -> str:
    cpu = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        names = [
            line
            for line in info.read_text().splitlines()
            if line.startswith(("model name", "Model"))
        ]
        cpu = names[0].partition(":")[2].strip() if names else cpu
    return (
        f"{cpu}, {os.cpu_count()} cores, Python {platform.python_version()}, numpy {np.__version__}"
    )


if __name__ == "__main__":
    main()
