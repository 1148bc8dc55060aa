"""`deltactl verify`: home, run, home, compare."""

from __future__ import annotations

import time
from dataclasses import asdict
from pathlib import Path

from deltactl.cli.output import NO_ROBOT, errors, print_json, say, tell
from deltactl.cli.robot.follow import follow, interrupted_between_sleeps
from deltactl.firmware_py.controller.build import build_controller
from deltactl.firmware_py.controller.contract import RobotController
from deltactl.firmware_py.controller.sensing.verify import Verification, verify
from deltactl.firmware_py.daemon.client import Client, daemon_answers
from deltactl.firmware_py.job_file import load_job
from deltactl.firmware_py.machine import is_raspberry_pi
from deltactl.firmware_py.named_files import JOB_KEY, ROBOT_KEY, find
from deltactl.firmware_py.robot_file import RobotFile, load_robot
from deltactl.foundation.errors import MotionError, ServiceError

POLL_S = 0.1


def verify_job(job: Path, simulate: bool, json_out: bool, socket: Path | None) -> None:
    """Print what was found. Raises MotionError when steps were lost."""
    path = find(str(job), key=JOB_KEY).resolve()
    robot_file = find(load_job(path).robot, beside=path, key=ROBOT_KEY)
    robot = load_robot(robot_file)
    if not simulate and daemon_answers(socket):
        with Client(socket) as client:
            if client.status().state == "off":
                client.power_on()
            found = _verify(client, robot, path, time.sleep, json_out)
    elif not simulate and is_raspberry_pi():
        raise ServiceError("no daemon answers; start it with 'sudo systemctl start deltactl'")
    else:
        if not simulate:
            tell(NO_ROBOT.format("running"), errors)
        found = _simulated(robot_file, robot, path, json_out)
    if json_out:
        print_json(asdict(found) | {"lost": list(found.lost)})
    elif not found.lost:
        say(found.says())
    if found.lost:
        raise MotionError(found.says())


def _simulated(robot_file: Path, robot: RobotFile, job: Path, quiet: bool) -> Verification:
    controller = build_controller(
        robot_file, simulated=True, realtime=False, recordings=Path("recordings")
    )
    try:
        with interrupted_between_sleeps(controller.clock) as sleep:
            controller.power_on()
            return _verify(controller, robot, job, sleep, quiet)
    finally:
        controller.close()


def _verify(  # type: ignore[no-untyped-def]
    controller: RobotController, robot: RobotFile, job: Path, sleep, quiet: bool
) -> Verification:
    def run(number: int) -> str:
        return follow(controller, number, sleep, POLL_S, quiet).outcome

    return verify(controller, robot, job, run, sleep)
