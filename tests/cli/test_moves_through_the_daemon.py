"""goto, jog and teach against a daemon that runs, through its socket."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from deltactl.cli.main import app
from deltactl.firmware_py.importing.points_table import read_points
from deltactl.firmware_py.planning.process import PlanningProcess
from deltactl.foundation.errors import DeltactlError
from deltactl.recording.reading.reader import read_run
from tests.rigs.served import Served, served

Deltactl = Callable[..., Result]
STEP_M = 1.5e-4
"""About what a whole step of a motor moves this platform."""


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """A simulated robot that is homed, and its socket."""
    with served(tmp_path_factory.mktemp("daemon")) as one:
        yield one


@pytest.fixture
def deltactl(robot: Served, monkeypatch: pytest.MonkeyPatch) -> Deltactl:
    """Commands to a robot that is ready."""
    monkeypatch.setenv("COLUMNS", "200")
    robot.ready()

    def run(*words: str) -> Result:
        return CliRunner().invoke(app, [*words, "--socket", str(robot.socket)])

    return run


def test_goto_jog_and_teach(deltactl: Deltactl, tmp_path: Path) -> None:
    table = str(tmp_path / "points.csv")
    said = deltactl("goto", "0", "10", "-300", "--speed", "200").output
    assert said.startswith("the platform is at ")
    deltactl("job", "teach", table, "--dwell", "0.5")
    moved = json.loads(deltactl("jog", "--x", "3", "--z", "-2", "--json").output)
    assert moved["outcome"] == "done"
    assert moved["position_m"] == pytest.approx([0.003, 0.01, -0.302], abs=2 * STEP_M)
    deltactl("job", "teach", table)
    drawn = read_points(Path(table), (0.0, 0.0, 0.0))
    assert drawn.start_m == pytest.approx((0.0, 0.01, -0.3), abs=STEP_M)
    assert drawn.legs[0] == {"to_m": drawn.start_m, "dwell_s": 0.5}  # it waits where it begins
    assert drawn.legs[1]["to_m"] == pytest.approx((0.003, 0.01, -0.302), abs=2 * STEP_M)


@pytest.mark.parametrize("speed", [20.0, 80.0])
def test_a_move_by_hand_is_straight_and_no_faster_than_asked(
    deltactl: Deltactl, speed: float
) -> None:
    deltactl("goto", "-20", "10", "-300", "--speed", "200")
    moved = json.loads(deltactl("jog", "--x", "40", "--speed", f"{speed:g}", "--json").output)
    truth = read_run(Path(moved["recording"])).truth
    place_m = truth.position_m
    assert np.abs(place_m[:, 1:] - place_m[-1, 1:]).max() < 2 * STEP_M
    hops_m = np.linalg.norm(place_m[5:] - place_m[:-5], axis=1)
    took_s = (truth.t_ns[5:] - truth.t_ns[:-5]) * 1e-9
    assert (hops_m <= 1.02 * speed * 1e-3 * took_s + 2 * STEP_M).all()
    assert hops_m.max() > 0.9 * speed * 1e-3 * np.median(took_s)


@pytest.mark.study
def test_a_move_that_is_refused_is_told_as_it_was_typed(
    robot: Served, deltactl: Deltactl, monkeypatch: pytest.MonkeyPatch
) -> None:
    planning = PlanningProcess()
    monkeypatch.setattr(robot.controller, "_prepare", planning.prepare)
    refused = str(deltactl("goto", "20", "0", "340").exception)
    planning.close()
    assert refused.startswith("goto: 20 0 340 mm: out of reach")
    assert "did you mean z = -340 mm?" in refused


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("goto", "0", "0", "-900"), "goto: 0 0 -900 mm: out of reach"),
        (("jog", "--z", "-600"), "out of reach"),
        (("jog",), "say how far"),
        (("goto", "0", "0", "-300", "--robot", "x.yaml"), "leave it out"),
        (
            ("run", "pick-and-place.yaml", "--accept-unseen", "40"),
            "deltactl home --accept-unseen 40",
        ),
        (("goto", "0", "0", "-300", "--accept-unseen", "40"), "deltactl home --accept-unseen 40"),
    ],
)
def test_what_is_refused_does_not_move(
    deltactl: Deltactl, words: tuple[str, ...], says: str
) -> None:
    before = json.loads(deltactl("status", "--json").output)["counts"]
    refused = deltactl(*words).exception
    assert isinstance(refused, DeltactlError)
    assert says in str(refused)
    assert "point" not in str(refused)
    assert "repeat" not in str(refused)
    assert json.loads(deltactl("status", "--json").output)["counts"] == before


@pytest.mark.study
def test_run_says_what_the_daemon_compensates(
    robot: Served, deltactl: Deltactl, tmp_path: Path
) -> None:
    mine = Path(shutil.copy(robot.socket.parent / "mine.yaml", tmp_path))
    corrected = tmp_path / "corrected.yaml"
    wrong_home = "{effect: home_offset, component: motor1, parameters: {angle: 0.01}}"
    corrected.write_text(f"{mine.read_text()}\neffects:\n- {wrong_home}\n")
    job = tmp_path / "up.yaml"
    job.write_text(
        "name: up\nrobot: mine.yaml\npath: {shape: points, points_m: [[0.0, 0.0, -0.3]]}\n"
        "timing: {mode: accelerated, speed_mps: 0.3}\ninverse_kinematics: {kind: geometry}\n"
    )
    deltactl("home", "--robot", str(corrected))
    ran = deltactl("run", str(job))
    deltactl("home", "--robot", str(mine))
    compensated = "compensated: home_offset on motor1, in the inverse kinematics"
    assert compensated in ran.output, ran.exception
    corrected.write_text("name: broken")
    assert "compensated" not in deltactl("run", str(job)).output


def test_after_a_fault_teach_says_what_happened_and_what_to_type(
    robot: Served, deltactl: Deltactl, tmp_path: Path
) -> None:
    controller = robot.controller
    with controller.condition.lock:
        controller._emergency.fault("no heartbeat: the controller hung for 0.6 s")
    refused = str(deltactl("job", "teach", str(tmp_path / "points.csv")).exception)
    for command in ("acknowledge", "home"):
        assert f"'deltactl {command}'" in refused
        assert deltactl(command).exception is None
    assert refused.startswith(
        "the position is unknown since the fault (no heartbeat: the controller hung for 0.6 s; this"
        " computer was too busy to simulate the robot in real time: end other programs, and close"
        " pages that show it); 'deltactl acknowledge',"
    )
    assert deltactl("job", "teach", str(tmp_path / "points.csv")).exception is None


@pytest.mark.study
def test_after_a_stop_the_simulated_robot_is_homed_where_its_arms_are(
    robot: Served, deltactl: Deltactl
) -> None:
    controller = robot.controller
    world = controller.machine.world
    assert world is not None
    deltactl("goto", "0", "15", "-305", "--speed", "200")
    said = deltactl("stop").output
    assert said == "stopped; 'deltactl acknowledge', 'deltactl home'\n"
    for command in ("acknowledge", "home"):
        done = deltactl(command)
        assert done.exception is None
    assert "warning" not in done.output
    status = json.loads(deltactl("status", "--json").output)
    truth = world.truth(controller.clock.now_ns())
    assert status["angles_rad"] == pytest.approx(truth.angles_rad, abs=2e-3)
