"""A small delta with a gripper, simulated on a virtual clock."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from deltactl.firmware_py.controller.build import build_controller
from deltactl.firmware_py.controller.contract import JobResult
from deltactl.firmware_py.controller.controller import Controller
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.foundation.clock import sleep_s

HEAD = """\
name: steps
robot: gripper-delta.yaml
timing: {mode: accelerated, speed_mps: 0.3}
inverse_kinematics: {kind: geometry}
on_blind: warn
"""

Write = Callable[[str], Path]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name in ("gripper-delta.yaml", "pick.yaml", "pick-and-place.yaml"):
        shutil.copy(CONFIG_FOLDER / name, tmp_path / name)
    return tmp_path


@pytest.fixture
def write(folder: Path) -> Write:
    """A job of these steps, beside the robot file."""

    def of(steps: str, head: str = HEAD) -> Path:
        path = folder / "steps.yaml"
        path.write_text(f"{head}steps:\n{steps}")
        return path

    return of


@pytest.fixture
def controller(folder: Path) -> Iterator[Controller]:
    """Homed."""
    made = build_controller(
        folder / "gripper-delta.yaml", simulated=True, realtime=False, recordings=folder
    )
    made.power_on()
    made.home()
    yield made
    made.close()


def finished(controller: Controller, number: int, limit_s: float = 60.0) -> JobResult:
    """The result of a job, once it has one."""
    for _ in range(round(limit_s / 0.05)):
        result = controller.result(number)
        if result is not None:
            return result
        sleep_s(controller.clock, 0.05)
    raise AssertionError(f"job {number} does not end: {controller.status()}")
