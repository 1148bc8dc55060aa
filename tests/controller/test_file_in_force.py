"""The recording carries the robot file that is in force, and the status says of a changed one."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from deltactl.firmware_py.controller.build import build_controller
from deltactl.firmware_py.controller.controller import Controller
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.recording.reading.reader import read_run

TEXT = (CONFIG_FOLDER / "zhao-2023.yaml").read_text()


@pytest.fixture
def robot_file(tmp_path: Path) -> Path:
    path = tmp_path / "shared.yaml"
    path.write_text(TEXT)
    return path


@pytest.fixture
def controller(robot_file: Path, tmp_path: Path) -> Iterator[Controller]:
    made = build_controller(
        robot_file, simulated=True, realtime=False, recordings=tmp_path / "recordings"
    )
    made.power_on()
    made.home()
    yield made
    made.close()


def test_a_file_changed_for_another_machine_is_not_recorded(
    controller: Controller, robot_file: Path, write_job, finish
) -> None:
    assert controller.status().robot_file_changed == ""
    other = TEXT.replace("forearm_m: 0.5 ", "forearm_m: 0.52 ")
    assert other != TEXT
    robot_file.write_text(other)
    assert str(robot_file) in controller.status().robot_file_changed
    assert "deltactl power off" in controller.status().robot_file_changed
    result = finish(controller, controller.submit(write_job(robot=robot_file)))
    assert result.outcome == "done"
    assert read_run(Path(result.recording)).configuration.robot_text == TEXT


def test_a_file_written_again_with_the_same_text_has_not_changed(
    controller: Controller, robot_file: Path
) -> None:
    robot_file.write_text(TEXT)
    assert controller.status().robot_file_changed == ""
    robot_file.unlink()
    assert controller.status().robot_file_changed != ""
    robot_file.write_text(TEXT)
    assert controller.status().robot_file_changed == ""
