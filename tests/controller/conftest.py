"""A controller on the simulated robot with a virtual clock, and small jobs for it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from deltactl.firmware_py.controller.build import build_controller
from deltactl.firmware_py.controller.contract import JobResult
from deltactl.firmware_py.controller.controller import Controller
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.foundation.clock import sleep_s

ROBOT = CONFIG_FOLDER / "zhao-2023.yaml"
JOB = """name: {name}
robot: {robot}
path: {{shape: circle, centre_m: [0.0, 0.0, -0.45], radius_m: {radius_m}}}
timing: {{t_pwm_s: {t_pwm_s}}}
inverse_kinematics: {{kind: geometry}}
"""

WriteJob = Callable[..., Path]
Finish = Callable[[Controller, int], JobResult]


@pytest.fixture
def controller(tmp_path: Path) -> Iterator[Controller]:
    made = build_controller(
        ROBOT, simulated=True, realtime=False, recordings=tmp_path / "recordings"
    )
    yield made
    made.close()


@pytest.fixture
def homed(controller: Controller) -> Controller:
    controller.power_on()
    controller.home()
    return controller


@pytest.fixture
def write_job(tmp_path: Path) -> WriteJob:
    def write(
        name: str = "little", radius_m: float = 0.02, t_pwm_s: float = 0.006, robot: Path = ROBOT
    ) -> Path:
        path = tmp_path / f"{name}.yaml"
        path.write_text(JOB.format(name=name, radius_m=radius_m, t_pwm_s=t_pwm_s, robot=robot))
        return path

    return write


@pytest.fixture
def finish() -> Finish:
    def wait(controller: Controller, number: int) -> JobResult:
        for _ in range(1000):
            result = controller.result(number)
            if result is not None:
                return result
            sleep_s(controller.clock, 0.1)
        raise AssertionError("the job does not end within 100 s of robot time")

    return wait
