"""What feeds the watchdog: every loop of the real controller must go round."""

from __future__ import annotations

from pathlib import Path

import pytest

from deltactl.firmware_py.controller.build import build_controller
from deltactl.firmware_py.controller.control_loop import Progress
from deltactl.firmware_py.controller.controller import Controller
from deltactl.firmware_py.install.steps import PROGRAM
from deltactl.foundation.clock import sleep_s


@pytest.fixture
def controller(tmp_path: Path):
    robot = PROGRAM / "config/zhao-2023.yaml"
    one = build_controller(robot, simulated=True, realtime=False, recordings=tmp_path)
    yield one
    one.close()


def _grows(controller: Controller, within_s: float) -> bool:
    controller.progress_count()
    before = controller.progress_count()
    sleep_s(controller.clock, within_s)
    return controller.progress_count() > before


def test_switching_on_after_a_long_time_off_does_not_look_like_hanging(controller):
    sleep_s(controller.clock, 10.0)
    assert _grows(controller, 0.1)
    controller.power_on()
    for _ in range(5):
        assert _grows(controller, 0.1)
    controller.stop("test")
    assert _grows(controller, 0.1)


def test_one_hanging_loop_is_enough(controller):
    controller.power_on()
    sleep_s(controller.clock, 1.0)
    assert _grows(controller, 0.1)
    controller.ranging.stop()
    sleep_s(controller.clock, 0.1)
    assert not _grows(controller, 1.0)


def test_a_loop_that_is_far_ahead_cannot_hide_that_it_hangs():
    progress = Progress()
    counts = [progress.count(control=1000, ranging=n) for n in range(10)]
    assert len(set(counts)) == 1
    assert progress.count(control=1001, ranging=10) == counts[0] + 1
