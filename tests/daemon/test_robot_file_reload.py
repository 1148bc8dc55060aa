"""Another robot file comes into force through the socket: off and on, or at homing."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from deltactl.firmware_py.controller.build import build_controller
from deltactl.firmware_py.controller.controller import Controller
from deltactl.firmware_py.daemon.client import Client
from deltactl.firmware_py.daemon.listener import Listener
from deltactl.firmware_py.daemon.server import Server
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.foundation.clock import sleep_s
from deltactl.foundation.errors import ConfigError, NotReady

TEXT = (CONFIG_FOLDER / "zhao-2023.yaml").read_text()
MICROSTEP_M = 1e-4
BELIEF = "\neffects:\n- {effect: home_offset, component: motor2, parameters: {angle: 0.02}}\n"
AS_BUILT = (
    "\nas_built:\n  effects:\n"
    "  - {effect: home_offset, component: motor2, parameters: {angle: 0.02}}\n"
)


@dataclass
class Served:
    controller: Controller
    client: Client
    robot_file: Path


@pytest.fixture
def served(tmp_path: Path) -> Iterator[Served]:
    robot_file = tmp_path / "mine.yaml"
    robot_file.write_text(TEXT + AS_BUILT)
    controller = build_controller(
        robot_file, simulated=True, realtime=False, recordings=tmp_path / "recordings"
    )
    listener = Listener(tmp_path / "s")
    with (
        Server(controller, listener, tmp_path / "jobs", tmp_path / "recordings"),
        Client(tmp_path / "s") as client,
    ):
        yield Served(controller, client, robot_file)
    controller.close()


def off_target_m(served: Served) -> float:
    """How far the simulated platform truly is from where the robot believes it is, at home."""
    world = served.controller.machine.world
    counted_m = served.client.status().position_m
    assert world is not None
    assert counted_m is not None
    true = world.truth(served.controller.clock.now_ns()).position_m
    return max(abs(one - other) for one, other in zip(true, counted_m, strict=True))


def test_off_and_on_takes_the_file_as_it_is_by_now(served: Served) -> None:
    served.client.power_on()
    served.client.home()
    assert off_target_m(served) > 1e-3
    served.robot_file.write_text(TEXT + AS_BUILT + BELIEF)
    assert (
        "'deltactl power off' and 'deltactl power on'" in served.client.status().robot_file_changed
    )
    served.client.power_off()
    served.client.power_on()
    assert served.client.status().robot_file_changed == ""
    served.client.home()
    assert len(served.controller.robot.effects) == 1
    assert off_target_m(served) < MICROSTEP_M


def test_what_was_wired_otherwise_needs_a_restart_and_a_broken_file_is_not_taken(
    served: Served,
) -> None:
    served.robot_file.write_text(TEXT.replace("step_pins: [17, 27, 22]", "step_pins: [17, 27, 12]"))
    served.client.power_on()
    assert "steps, too); restart the daemon" in served.client.status().robot_file_changed
    served.client.power_off()
    served.robot_file.write_text(TEXT + "\nlimitz: {}\n")
    served.client.power_on()
    assert "limitz" in served.client.status().robot_file_changed
    assert served.controller.robot.steps.step_pins == (17, 27, 22)


def test_homing_with_a_corrected_file_puts_it_in_force_and_leaves_the_truth(
    served: Served, tmp_path: Path
) -> None:
    corrected = tmp_path / "corrected.yaml"
    corrected.write_text(TEXT.replace("name: zhao-2023", "name: renamed") + BELIEF)
    served.client.power_on()
    served.client.home(robot=corrected)
    assert off_target_m(served) < MICROSTEP_M
    assert served.controller.robot.name == "zhao-2023"  # as recordings are named
    other = tmp_path / "other.yaml"
    other.write_text(TEXT.replace("forearm_m: 0.5 ", "forearm_m: 0.52 "))
    with pytest.raises(ConfigError, match="another machine"):
        served.client.home(robot=other)
    assert served.client.status().state == "ready"
    served.client.power_off()
    with pytest.raises(NotReady):
        served.client.home(robot=corrected)


def test_a_corrected_file_that_the_daemon_cannot_read_is_sent(
    served: Served, tmp_path: Path
) -> None:
    """As from a folder that is private to somebody; jobs name the file that they always did."""
    corrected = tmp_path / "corrected.yaml"
    corrected.write_text(TEXT + BELIEF)
    link = tmp_path / "to-corrected.yaml"
    link.symlink_to(corrected)  # the daemon follows none
    served.client.power_on()
    served.client.home(robot=link)
    assert off_target_m(served) < MICROSTEP_M
    assert served.client.status().robot_file.startswith("to-corrected-")
    job = (
        "name: up\nrobot: mine.yaml\npath: {shape: points, points_m: [[0.0, 0.0, -0.45]]}\n"
        "timing: {mode: accelerated, speed_mps: 0.3}\ninverse_kinematics: {kind: geometry}\n"
    )
    number = served.client.submit_text(job, "up.yaml")
    while served.client.result(number) is None:
        sleep_s(served.controller.clock, 0.5)
    served.client.home(robot=served.robot_file)
    assert served.client.status().robot_file == "mine.yaml"
    longer = TEXT.replace("forearm_m: 0.5 ", "forearm_m: 0.52 ")
    with pytest.raises(ConfigError, match=r"^worse\.yaml: .*another machine"):
        served.client.home_by_text(longer, "worse.yaml")
