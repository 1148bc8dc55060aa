"""What a tick of the servo loop costs, and how much faster than real time whole runs are.

    python benchmarks/costs/servo.py

Processor time of this process, so that other work on the machine counts little; wall time beside
it. The control tick is everything the controller would do in a period on a real drive (encoder
counts in, three currents out); the simulated tick adds the fake drives and the plant.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from deltactl.drivers.fakes.current_drives import FakeCurrentDrives
from deltactl.drivers.steps.contract import Ticks
from deltactl.firmware_py.controller.build import build_controller
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.robot_file import load_robot
from deltactl.firmware_py.servo.law import AccelerationControl, LawSettings
from deltactl.firmware_py.servo.loop import ServoLoop
from deltactl.firmware_py.simulation.servo_world import plant_of
from deltactl.foundation.clock import NS_PER_S, sleep_s
from deltactl.models.servo_drive import ServoDrive

ROBOT = CONFIG_FOLDER / "uzunovic-2013.yaml"
JOB = CONFIG_FOLDER / "micro-circle.yaml"
ALLOWED_US, ALLOWED_RATIO = 10.0, 5.0
BLOCKS = 2000


def best_us(run: Callable[[], int], repeats: int = 5) -> tuple[float, float]:
    """Smallest and largest processor time of a tick [us]; `run` returns how many it made."""
    costs = []
    for _ in range(repeats):
        start_s = time.process_time()
        ticks = run()
        costs.append((time.process_time() - start_s) / ticks * 1e6)
    return min(costs), max(costs)


def control_tick(drive: ServoDrive) -> tuple[float, float]:
    """Observers, reference filter and law of three joints."""
    control = AccelerationControl(LawSettings.of(drive))
    t_s = np.arange(20_000) * drive.period_s
    swing = 0.1 * np.sin(2 * np.pi * np.outer(t_s, [0.2, 0.4, 0.6]))
    references = [tuple(row) for row in swing.tolist()]
    counts = [tuple(row) for row in np.rint(swing / drive.rad_per_count).astype(int).tolist()]

    def run() -> int:
        for reference, count in zip(references, counts, strict=True):
            control.tick(reference, count)
        return len(references)

    return best_us(run)


def simulated_tick(drive: ServoDrive) -> tuple[float, float]:
    """The whole loop: set-points, encoders, law, plant, samples for the recording."""
    robot = load_robot(ROBOT)
    assert robot.masses is not None
    drives = FakeCurrentDrives(
        plant_of(robot, drive, robot.masses),
        period_s=drive.period_s,
        rad_per_count=drive.rad_per_count,
        current_limit_a=drive.current_limit_a,
    )
    loop = ServoLoop(drive, drives, 0)
    drives.enable()
    loop.settle()
    block_ns = NS_PER_S // 1000

    def run() -> int:
        start_ns = loop.due_ns
        for block in range(BLOCKS):
            now_ns = start_ns + block * block_ns
            if block % 10 == 0:  # as the controller feeds
                due_ns = now_ns + block_ns // 4 * np.arange(1, 41)
                steps = np.full((40, 3), 1 if block // 500 % 2 else -1, dtype=np.int8)
                loop.setpoints.push(Ticks(due_ns, steps), now_ns)
            wrong = loop.run(now_ns + block_ns)
            assert not wrong, wrong
        loop.take_samples()
        loop.setpoints.take_sent()
        return BLOCKS * drive.loop_rate_hz // 1000

    return best_us(run)


def whole_run() -> tuple[float, float, float]:
    """Robot, processor and wall time of a job, from power on to its result [s]."""
    with tempfile.TemporaryDirectory() as folder:
        controller = build_controller(
            ROBOT, simulated=True, realtime=False, recordings=Path(folder)
        )
        wall_s, used_s, begun_ns = time.monotonic(), time.process_time(), controller.clock.now_ns()
        controller.power_on()
        controller.home()
        number = controller.submit(JOB)
        while controller.result(number) is None:
            sleep_s(controller.clock, 0.5)
        controller.close()
        robot_s = (controller.clock.now_ns() - begun_ns) / NS_PER_S
        return robot_s, time.process_time() - used_s, time.monotonic() - wall_s


def main() -> None:
    """Print every figure with what is asked of it."""
    drive = load_robot(ROBOT).drive
    assert isinstance(drive, ServoDrive)
    law, simulated = control_tick(drive), simulated_tick(drive)
    robot_s, used_s, wall_s = whole_run()
    period_us = 1e6 * drive.period_s
    print(f"control tick, three joints      {law[0]:6.2f} to {law[1]:.2f} us", end="")
    print(f"   (asked: {ALLOWED_US:g}; the period is {period_us:g})")
    print(f"the same with drives and plant  {simulated[0]:6.2f} to {simulated[1]:.2f} us")
    print(
        f"{JOB.name}: {robot_s:.1f} s of the robot in {used_s:.2f} s of processor time"
        f" ({wall_s:.2f} s wall): {robot_s / used_s:.1f} times as fast"
        f" (asked: {ALLOWED_RATIO:g})"
    )


if __name__ == "__main__":
    main()
