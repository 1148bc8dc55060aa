"""While a robot file is read, which may take a while, the controller answers and stops."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from deltactl.firmware_py.controller.build import build_controller
from deltactl.firmware_py.controller.controller import Controller
from deltactl.firmware_py.controller.file_in_force import FileInForce
from deltactl.firmware_py.controller.states import State
from deltactl.firmware_py.file_access import FileAccess
from deltactl.firmware_py.planning.prepared import Readers, RobotRead, read_robot_here
from deltactl.foundation.errors import DeltactlError, NotReady
from tests.controller.conftest import ROBOT

ANSWERS_S = 1.0


class SlowReader:
    """Reads as `read_robot_here` does, once it may."""

    def __init__(self) -> None:
        self.asked, self.may = threading.Event(), threading.Event()

    def __call__(self, path: Path, access: FileAccess) -> RobotRead:
        self.asked.set()
        assert self.may.wait(30.0)
        return read_robot_here(path, access)


@pytest.fixture
def reader() -> Iterator[SlowReader]:
    one = SlowReader()
    yield one
    one.may.set()


@pytest.fixture
def slow(tmp_path: Path, reader: SlowReader) -> Iterator[Controller]:
    robot = tmp_path / "robot.yaml"
    robot.write_text(ROBOT.read_text())
    readers = Readers(read=reader)
    made = build_controller(
        robot, simulated=True, realtime=False, recordings=tmp_path, readers=readers
    )
    yield made
    made.close()


def in_time(act: Callable[[], object]) -> object:
    begun_s = time.monotonic()
    answer = act()
    assert time.monotonic() - begun_s < ANSWERS_S
    return answer


def test_a_home_that_reads_a_file_holds_up_nobody(
    slow: Controller, reader: SlowReader, tmp_path: Path
) -> None:
    slow.power_on()
    refused: list[DeltactlError] = []

    def home() -> None:
        try:
            slow.home(robot=tmp_path / "robot.yaml")
        except DeltactlError as error:
            refused.append(error)

    homing = threading.Thread(target=home)
    homing.start()
    assert reader.asked.wait(10.0)
    in_time(slow.status)
    in_time(lambda: slow.stop("a hand in the way"))
    in_time(slow.acknowledge)
    reader.may.set()
    homing.join()
    assert isinstance(refused[0], NotReady)  # what was stopped is not homed afterwards
    assert slow.status().state == State.UNHOMED.value


def test_an_on_that_reads_a_changed_file_holds_up_nobody(
    slow: Controller, reader: SlowReader, tmp_path: Path
) -> None:
    robot = tmp_path / "robot.yaml"
    robot.write_text(robot.read_text() + "# changed\n")
    switching = threading.Thread(target=slow.power_on)
    switching.start()
    assert reader.asked.wait(10.0)
    in_time(slow.status)
    reader.may.set()
    switching.join()
    assert slow.status().state == State.UNHOMED.value


def test_a_status_does_not_wait_for_a_file_that_was_written_to(
    reader: SlowReader, tmp_path: Path
) -> None:
    robot = tmp_path / "robot.yaml"
    robot.write_text(ROBOT.read_text())
    found = read_robot_here(robot, FileAccess())
    file = FileInForce(robot, reader, found=found)
    assert file.changed(found.robot) == ""
    robot.write_text(robot.read_text() + "nonsense: 1\n")
    assert "is being read" in str(in_time(lambda: file.changed(found.robot)))
    reader.may.set()
    give_up_s = time.monotonic() + 10.0
    while "cannot be used" not in (says := file.changed(found.robot)):
        assert time.monotonic() < give_up_s, says
    assert "nonsense" in says
