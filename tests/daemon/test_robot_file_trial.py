"""A robot file on trial is in force as long as the client that tries it is there."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from deltactl.firmware_py.controller.build import build_controller
from deltactl.firmware_py.controller.contract import Status
from deltactl.firmware_py.daemon.client import Client
from deltactl.firmware_py.daemon.listener import Listener
from deltactl.firmware_py.daemon.server import Server
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.foundation.clock import sleep_s
from deltactl.foundation.errors import NotReady

TEXT = (CONFIG_FOLDER / "zhao-2023.yaml").read_text()
TRIED = "\neffects:\n- {effect: home_offset, component: motor2, parameters: {angle: 0.005}}\n"
CIRCLE = (
    "name: round\nrobot: mine.yaml\n"
    "path: {shape: circle, centre_m: [0.0, 0.0, -0.45], radius_m: 0.03}\n"
    "timing: {mode: together, t_pwm_s: 0.006}\nrepeats: 50\n"
    "inverse_kinematics: {kind: geometry}\n"
)
SOON_S = 10.0


class Robot:
    """The one that is served; two clients look at it."""

    def __init__(self, folder: Path):
        self.folder, self.socket = folder, folder / "s"
        self.mine, self.tried = folder / "mine.yaml", folder / "tried.yaml"
        self.mine.write_text(TEXT)
        self.tried.write_text(TEXT + TRIED)
        self.controller = build_controller(
            self.mine, simulated=True, realtime=False, recordings=folder / "recordings"
        )

    def client(self) -> Client:
        return Client(self.socket)

    def until(self, seen: Callable[[Status], bool]) -> Status:
        give_up_s = time.monotonic() + SOON_S
        while not seen(status := self.controller.status()):
            assert time.monotonic() < give_up_s, status
            sleep_s(self.controller.clock, 0.1)
            time.sleep(0.005)
        return status

    def file(self) -> str:
        return self.controller.status().robot_file


@pytest.fixture
def robot(tmp_path: Path) -> Iterator[Robot]:
    made = Robot(tmp_path)
    listener = Listener(made.socket)
    with Server(made.controller, listener, tmp_path / "jobs", tmp_path / "recordings"):
        made.controller.power_on()
        yield made
    made.controller.close()


@pytest.mark.parametrize("doing", ["ready", "running", "stopped", "off"])
def test_the_file_from_before_is_in_force_when_its_client_has_gone(
    robot: Robot, doing: str
) -> None:
    tries = robot.client()
    tries.home(robot=robot.tried, trial=True)
    assert robot.file() == "tried.yaml"
    if doing == "running":
        tries.submit_text(CIRCLE, "round.yaml")
        robot.until(lambda status: status.state == "running")
    elif doing == "stopped":
        tries.stop("enough")
    elif doing == "off":
        tries.power_off()
    tries.close()
    after = robot.until(lambda status: status.robot_file == "mine.yaml")
    assert after.state == {"ready": "unhomed", "running": "unhomed"}.get(doing, doing)
    assert not robot.controller.robot.effects
    if doing == "stopped":
        assert after.why == "enough"
    with robot.client() as other:
        if doing == "stopped":
            other.acknowledge()
        elif doing == "off":
            other.power_on()
        other.home()
        assert (robot.file(), robot.controller.status().state) == ("mine.yaml", "ready")


def test_nobody_else_starts_a_job_by_a_file_on_trial_and_a_home_ends_it(robot: Robot) -> None:
    with robot.client() as tries, robot.client() as other:
        tries.home(robot=robot.tried, trial=True)
        tries.home()
        assert robot.file() == "tried.yaml"
        with pytest.raises(NotReady, match=r"mine\.yaml"):
            other.submit_text(CIRCLE, "round.yaml")
        other.home()
        assert robot.file() == "mine.yaml"
        other.submit_text(CIRCLE, "round.yaml")
        tries.close()
        robot.until(lambda status: status.state == "running")
        other.cancel()


def test_a_file_that_is_taken_for_good_after_its_trial_stays(robot: Robot) -> None:
    with robot.client() as tries:
        tries.home(robot=robot.tried, trial=True)
        tries.home(robot=robot.tried)
    with robot.client() as other:
        other.home()
        assert robot.file() == "tried.yaml"


def test_a_second_file_on_trial_does_not_hide_the_first(robot: Robot) -> None:
    """What comes back is the file that nobody was trying."""
    again = robot.folder / "again.yaml"
    again.write_text(TEXT + TRIED.replace("0.005", "0.003"))
    with robot.client() as tries:
        tries.home(robot=robot.tried, trial=True)
        tries.home(robot=again, trial=True)
        assert robot.file() == "again.yaml"
    robot.until(lambda status: status.robot_file == "mine.yaml")
