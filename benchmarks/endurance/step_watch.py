"""What the step watch sees, and how soon: python benchmarks/endurance/step_watch.py [--hours 1].

On the simulated Zhao robot and the virtual clock: jumps of several sizes and stalled motors at
several step periods, each at random moments of a circle, then hours without any fault.
"Seen in 1 s" is the share of the faults that ended the run within a second.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from random import Random

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np

from deltactl.firmware_py.controller.build import build_controller
from deltactl.firmware_py.controller.controller import Controller
from deltactl.firmware_py.controller.states import State
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.foundation.clock import NS_PER_S, sleep_s

ROBOT = CONFIG_FOLDER / "zhao-2023.yaml"
JOB = """
name: watched
robot: {robot}
path: {{shape: {shape}, centre_m: [0.0, 0.0, -0.45], {size}, turns: 200}}
timing: {{mode: together, t_pwm_s: {t_pwm_s}}}
inverse_kinematics: {{kind: geometry}}
"""
PERIODS_S = (0.002, 0.006, 0.01, 0.02)
JUMPS = (40, 60, 80, 100, 150)
WARM_S, WAIT_S = 75.0, 10.0
BUILT = """
  effects:
    - {effect: gear_backlash, component: motor1, parameters: {width: 0.006}}
    - {effect: gear_backlash, component: motor2, parameters: {width: 0.006}}
    - {effect: home_offset, component: motor3, parameters: {angle: 0.02}}
    - {effect: forearm_length, component: arm1, parameters: {length_error: 0.004}}
    - {effect: sensor_scale, component: range_x, parameters: {scale: 1.01}}
    - {effect: sensor_latency, component: sensors, parameters: {time: 0.02}}
"""
"""Errors of the model all at once: play, home, length, scale, latency."""
STEP_MM = 0.25e3 * np.deg2rad(0.0225)


class Watched:
    """A robot that runs a circle again and again."""

    def __init__(
        self, folder: Path, t_pwm_s: float, seed: int, shape: str = "circle", built: str = ""
    ):
        self.controller: Controller = build_controller(
            _robot(folder, seed, built), simulated=True, realtime=False, recordings=folder
        )
        self.job = folder / f"job-{t_pwm_s:g}.yaml"
        size = "radius_m: 0.1" if shape == "circle" else "width_m: 0.2"
        text = JOB.format(robot="robot.yaml", shape=shape, size=size, t_pwm_s=t_pwm_s)
        self.job.write_text(text)
        self.chance = Random(seed)

    def begin(self, warm_s: float) -> None:
        """From any state to the middle of a run."""
        controller = self.controller
        if controller.condition.state in (State.FAULT, State.STOPPED):
            controller.power_off()
            controller.acknowledge()
        elif controller.condition.state is State.OFF:
            controller.power_on()
        controller.home()
        controller.submit(self.job)
        sleep_s(controller.clock, warm_s + self.chance.uniform(0.0, 5.0))
        assert controller.condition.state is State.RUNNING, controller.condition.why

    def seen_after_s(self, fault: Callable[[int], None], motor: int) -> tuple[float, bool]:
        """Seconds from the fault to its being seen (inf: not within WAIT_S); the right motor."""
        controller = self.controller
        start_ns = controller.clock.now_ns()
        fault(motor)
        end_ns = start_ns + WAIT_S * NS_PER_S
        while controller.condition.state is State.RUNNING and controller.clock.now_ns() < end_ns:
            sleep_s(controller.clock, 0.01)
        if controller.condition.state is State.RUNNING:
            controller.cancel()
            sleep_s(controller.clock, 3.0)
            controller.power_off()
            return float("inf"), False
        after_s = (controller.clock.now_ns() - start_ns) / NS_PER_S
        return after_s, f"motor{motor} " in controller.condition.why


def _robot(folder: Path, seed: int, built: str) -> Path:
    path = folder / "robot.yaml"
    noise = f"\nas_built:\n  noise: {{sigma_m: 0.0015, seed: {seed}}}\n{built}"
    path.write_text(ROBOT.read_text(encoding="utf-8") + noise, encoding="utf-8")
    return path


def jumps(folder: Path, times: int) -> None:
    """The table of jumps."""
    print(
        f"{'jump, steps':>12}{'mm at elbow':>12}"
        f"{'seen in 1 s':>12}{'median, s':>11}{'worst, s':>10}"
    )
    for steps in JUMPS:
        watched = Watched(folder, 0.006, steps)
        bench = watched.controller.machine.bench
        assert bench is not None
        found = []
        for number in range(times):
            watched.begin(WARM_S if number == 0 else 30.0)
            signed = watched.chance.choice((-1, 1)) * steps
            after_s, _ = watched.seen_after_s(partial(bench.slip, steps=signed), number % 3 + 1)
            found.append(after_s)
        watched.controller.close()
        _row(f"{steps:12d}{steps * STEP_MM:12.1f}", found)


def stalls(folder: Path, times: int) -> None:
    """The table of stalled motors, by the speed at which they should have moved."""
    print(
        f"\n{'T_PWM, s':>10}{'motor, mm/s':>14}{'seen in 1 s':>12}{'median, s':>11}{'worst, s':>10}"
    )
    by_speed: dict[int, list[float]] = {}
    for t_pwm_s in PERIODS_S:
        watched = Watched(folder, t_pwm_s, 7)
        bench = watched.controller.machine.bench
        assert bench is not None
        for number in range(times):
            watched.begin(WARM_S if number == 0 else 20.0)
            motor = number % 3 + 1
            before = watched.controller.status().counts[motor - 1]
            start_ns = watched.controller.clock.now_ns()
            after_s, _ = watched.seen_after_s(bench.stall, motor)
            bench.stall(motor, False)
            moved = abs(watched.controller.status().counts[motor - 1] - before)
            over_s = min(after_s, (watched.controller.clock.now_ns() - start_ns) / NS_PER_S)
            speed_mmps = moved * STEP_MM / max(over_s, 0.1)
            by_speed.setdefault(_bin(speed_mmps), []).append(after_s)
        watched.controller.close()
    for low, found in sorted(by_speed.items()):
        _row(f"{'':10}{f'{low} to {low * 2}':>14}", found)


def _bin(speed_mmps: float) -> int:
    return 1 << int(np.floor(np.log2(max(speed_mmps, 1.0))))


def _row(head: str, found: list[float]) -> None:
    array = np.array(found)
    share = float((array <= 1.0).mean())
    print(
        f"{head}{share:12.0%}{np.median(array):11.2f}{array.max():10.2f}  (n={len(array)})",
        flush=True,
    )


def quiet(folder: Path, hours: float) -> None:
    """False alarms without a fault: the robot of the file, and one that was built otherwise."""
    for shape, t_pwm_s, built in (
        ("heart", 0.006, ""),
        ("circle", 0.002, ""),
        ("heart", 0.006, BUILT),
        ("circle", 0.002, BUILT),
    ):
        watched = Watched(folder, t_pwm_s, 3, shape, built)
        controller = watched.controller
        watched.begin(0.0)
        alarms, end_ns = 0, controller.clock.now_ns() + round(hours * 3600 * NS_PER_S)
        while controller.clock.now_ns() < end_ns:
            sleep_s(controller.clock, 1.0)
            if controller.condition.state is not State.RUNNING:
                alarms += "lost steps" in controller.condition.why
                watched.begin(0.0)
        errors = "with errors of the model" if built else "as its file says"
        said = f"{hours:g} h of {shape}s at {t_pwm_s * 1e3:g} ms, {errors}"
        print(f"{said}: {alarms} false alarms", flush=True)
        controller.close()


def resting(folder: Path, hours: float) -> None:
    """Hours of rest at home and after a job: how often a robot that is still is called moved."""
    for built in ("", BUILT):
        watched = Watched(folder, 0.002, 4, "circle", built)
        robot = watched.controller
        short = folder / "short.yaml"
        short.write_text(watched.job.read_text().replace("turns: 200", "turns: 1"))
        for after_a_job in (False, True):
            alarms, end_ns = 0, robot.clock.now_ns() + round(hours * 3600 * NS_PER_S)
            _rest_again(robot, short if after_a_job else None)
            while robot.clock.now_ns() < end_ns:
                sleep_s(robot.clock, 1.0)
                if robot.condition.state is not State.READY:
                    alarms += 1
                    print(f"  {robot.condition.why}", flush=True)
                    _rest_again(robot, short if after_a_job else None)
            where = "after a job" if after_a_job else "at home"
            errors = "with errors of the model" if built else "as its file says"
            print(f"{hours:g} h of rest {where}, {errors}: {alarms} false alarms", flush=True)
        robot.close()


def _rest_again(robot: Controller, job: Path | None) -> None:
    if robot.condition.state in (State.FAULT, State.STOPPED):
        robot.power_off()
        robot.acknowledge()
    if robot.condition.state is State.OFF:
        robot.power_on()
    robot.home()
    if job is not None:
        robot.submit(job)
        sleep_s(robot.clock, 1.0)
        while robot.condition.state in (State.PLANNING, State.RUNNING):
            sleep_s(robot.clock, 0.1)


def main() -> None:
    """All tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--hours", type=float, default=1.0)
    parser.add_argument("--times", type=int, default=12)
    parser.add_argument("--only", choices=("jumps", "stalls", "quiet", "resting"))
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        if options.only in (None, "jumps"):
            jumps(Path(folder), options.times)
        if options.only in (None, "stalls"):
            stalls(Path(folder), options.times)
        if options.only in (None, "quiet"):
            quiet(Path(folder), options.hours)
        if options.only in (None, "resting"):
            resting(Path(folder), options.hours)


if __name__ == "__main__":
    main()
