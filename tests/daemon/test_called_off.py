"""Nothing moves after it was called off: by its client's death, by cancel, pause, off and stop.

Jobs are caught while they are planned; the robot's time is virtual, and passes only afterwards.
"""

from __future__ import annotations

import json
import signal
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest
from typer.testing import CliRunner

from deltactl.cli.main import app
from deltactl.firmware_py.controller.states import State
from deltactl.firmware_py.daemon.client import Client
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.foundation.errors import MotionError, NotReady
from tests.rigs.started import Started, started
from tests.rigs.two_clients import ServedRobot, until

MICRO = CONFIG_FOLDER / "uzunovic-2013.yaml"


@pytest.fixture
def robot(tmp_path: Path) -> Iterator[ServedRobot]:
    """Homed."""
    served = ServedRobot(tmp_path)
    _home(served)
    yield served
    served.close()


@pytest.fixture
def servo(tmp_path: Path) -> Iterator[ServedRobot]:
    """A micro delta, homed."""
    served = ServedRobot(tmp_path, MICRO)
    served.jobs["round"].write_text((CONFIG_FOLDER / "micro-circle.yaml").read_text())
    _home(served)
    yield served
    served.close()


def _home(served: ServedRobot) -> None:
    assert served.clients[0].ask("on")["ok"]
    assert served.clients[0].ask("home", accept_unseen_deg=360.0)["ok"]


def _in_a_process(robot: ServedRobot, *words: str) -> Started:
    """A command that waits for the check of its job."""
    command = started(*words, "--socket", robot.path)
    until(lambda: robot.state is State.PLANNING or command.poll() is not None, "the job is planned")
    assert command.poll() is None, command.communicate()
    return command


def _does_not_move(robot: ServedRobot) -> None:
    edges = robot.edges
    robot.pass_s(3.0)
    assert robot.edges == edges


@pytest.mark.parametrize(
    ("command", "number"),
    [
        ("run", signal.SIGINT),
        ("run", signal.SIGHUP),
        ("goto", signal.SIGKILL),
        ("detached", signal.SIGINT),
    ],
)
def test_a_client_that_ends_while_its_job_is_planned_takes_it_along(
    robot: ServedRobot, command: str, number: signal.Signals
) -> None:
    words = {
        "run": ("run", str(robot.jobs["round"])),
        "goto": ("goto", "0", "10", "-450"),
        "detached": ("run", str(robot.jobs["round"]), "--detach"),
    }
    client = _in_a_process(robot, *words[command])
    client.send_signal(number)
    said = client.communicate(timeout=120.0)[1]
    until(lambda: robot.state is State.READY, "the job is dropped")
    until(lambda: not robot.gates, "its check ends")
    if number is signal.SIGINT:
        assert client.returncode == 130
        assert "drops the job" in said
    _does_not_move(robot)
    assert robot.clients[0].ask("result", job_id=1)["result"]["outcome"] == "cancelled"


@pytest.mark.parametrize("how", ["cancel", "off", "stop"])
def test_what_calls_a_job_off_reaches_who_waits_for_it(robot: ServedRobot, how: str) -> None:
    client = _in_a_process(robot, "run", str(robot.jobs["round"]))
    behind = robot.clients[1].send("run", job=str(robot.jobs["there"]))
    assert CliRunner().invoke(app, [how, "--socket", str(robot.path)]).exit_code == 0
    said = client.communicate(timeout=120.0)[1]
    assert client.returncode == 2
    named = {"cancel": "cancelled", "off": "switched", "stop": "stop"}
    assert "cannot run" in said
    assert named[how] in said
    dropped = robot.clients[1].outcome(behind)
    assert not dropped["ok"]
    assert named[how] in dropped["error"]["message"]
    for request in ("acknowledge", "on", "home"):
        robot.clients[0].ask(request)
    assert robot.state is State.READY
    _does_not_move(robot)


@pytest.mark.study
def test_a_pause_holds_a_job_that_is_planned_until_it_is_resumed(robot: ServedRobot) -> None:
    run = robot.clients[0].send("run", job=str(robot.jobs["there"]))
    until(lambda: bool(robot.gates), "the job is planned")
    assert robot.clients[1].ask("pause")["ok"]
    robot.let_check_end()
    number = robot.clients[0].answer(run)["job_id"]
    _does_not_move(robot)
    assert robot.state is State.PAUSED
    assert robot.clients[1].ask("resume")["ok"]
    robot.pass_s(8.0)
    assert robot.clients[0].ask("result", job_id=number)["result"]["outcome"] == "done"


def test_the_status_shows_that_a_job_is_planned(robot: ServedRobot) -> None:
    robot.clients[0].send("run", job=str(robot.jobs["there"]))
    until(lambda: robot.state is State.PLANNING, "the job is planned")
    shown = CliRunner().invoke(app, ["status", "--socket", str(robot.path)], env={"COLUMNS": "80"})
    assert "planning" in shown.output
    assert "there" in shown.output
    status = robot.clients[1].ask("status")["status"]
    assert (status["planning"], status["planning_ids"]) == (["there"], [1])
    assert robot.clients[1].ask("cancel", job_id=1)["ok"]
    until(lambda: robot.state is State.READY, "it is dropped")


@pytest.mark.study
@pytest.mark.parametrize("kind", ["robot", "servo"])
def test_a_job_ends_on_its_path_when_its_client_dies(
    kind: str, request: pytest.FixtureRequest
) -> None:
    robot: ServedRobot = request.getfixturevalue(kind)
    jobs = [_accepted(robot, client, "round") for client in (0, 0, 1)]
    robot.pass_s(0.5)
    assert robot.state is State.RUNNING
    robot.clients[0].close()
    until(lambda: robot.controller.jobs.claims()[0].called_off != "", "it is called off")
    robot.pass_s(2.5)
    robot.reconnect(0)
    ended = [robot.clients[1].ask("result", job_id=job)["result"] for job in jobs]
    assert [one["outcome"] for one in ended[:2]] == ["cancelled", "cancelled"]
    assert "client" in ended[0]["why"]
    # That of the other client goes on, to its end where it is short.
    if ended[2] is None:
        assert robot.controller.status().job_id == jobs[2]
        assert robot.clients[1].ask("cancel")["ok"]
        robot.pass_s(2.5)
    else:
        assert ended[2]["outcome"] == "done"
    assert robot.state is State.READY
    _does_not_move(robot)


def _accepted(robot: ServedRobot, client: int, name: str, **more: object) -> int:
    number = robot.clients[client].send("run", job=str(robot.jobs[name]), **more)
    robot.let_check_end()
    answer = robot.clients[client].answer(number)
    assert answer["ok"], answer
    return int(answer["job_id"])


@pytest.mark.study
def test_a_pause_outlives_the_client_whose_job_it_holds(robot: ServedRobot) -> None:
    """Another client's job waits behind it, and nobody resumed."""
    _accepted(robot, 0, "round")
    waits = _accepted(robot, 1, "there")
    robot.pass_s(0.5)
    assert robot.clients[1].ask("pause")["ok"]
    robot.pass_s(1.5)
    robot.clients[0].close()
    until(lambda: robot.state is State.RUNNING, "its job ends")
    robot.pass_s(1.5)
    robot.reconnect(0)
    assert robot.state is State.PAUSED
    _does_not_move(robot)
    assert robot.clients[1].ask("resume")["ok"]
    robot.pass_s(8.0)
    assert robot.clients[1].ask("result", job_id=waits)["result"]["outcome"] == "done"


@pytest.mark.study
def test_a_detached_job_goes_on_alone_and_can_be_followed(robot: ServedRobot) -> None:
    client = _in_a_process(robot, "run", str(robot.jobs["there"]), "--detach", "--json")
    robot.let_check_end()
    number = json.loads(client.communicate(timeout=120.0)[0])["job_id"]
    assert client.returncode == 0
    robot.pass_s(8.0)
    followed = CliRunner().invoke(app, ["job", "follow", str(number), "--socket", str(robot.path)])
    assert f"job {number} 'there': done" in followed.output
    nothing = CliRunner().invoke(app, ["job", "follow", "--socket", str(robot.path)])
    assert isinstance(nothing.exception, NotReady)


def test_whoever_follows_is_told_how_the_job_ended(robot: ServedRobot) -> None:
    number = _accepted(robot, 0, "round", detach=True)
    assert robot.clients[1].ask("off")["ok"]
    followed = CliRunner().invoke(app, ["job", "follow", str(number), "--socket", str(robot.path)])
    assert isinstance(followed.exception, MotionError)
    assert "switched off" in str(followed.exception)


@pytest.mark.parametrize("words", [("--simulate",), ("--report", "page.html")])
def test_what_cannot_be_detached_is_refused(
    robot: ServedRobot, words: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    run = ["run", str(robot.jobs["there"]), "--detach", *words, "--socket", str(robot.path)]
    assert "--detach" in str(CliRunner().invoke(app, run).exception)
    assert robot.state is State.READY


def test_a_home_ends_with_its_client(robot: ServedRobot) -> None:
    _accepted(robot, 0, "there", detach=True)
    robot.pass_s(8.0)
    seen: list[State] = []

    def dies() -> None:
        robot.clients[1].close()
        until(lambda: robot.state is not State.HOMING, "the homing is called off")
        seen.append(robot.state)

    robot.meanwhile(0.2, dies)
    robot.clients[1].send("home")
    until(lambda: bool(seen), "its client dies")
    robot.clients[0].ask("on")  # refused, once the homing has ended
    robot.reconnect(1)
    assert seen == [State.UNHOMED]
    robot.pass_s(0.2)
    _does_not_move(robot)
    assert robot.clients[0].ask("home")["ok"]


def test_a_client_that_only_ended_its_requests_is_there_until_its_job_ends(
    robot: ServedRobot,
) -> None:
    """As `socat` does it with a long -t."""
    number = robot.clients[0].send("run", job=str(robot.jobs["there"]))
    robot.clients[0].half_close()
    robot.let_check_end()
    job = robot.clients[0].answer(number)["job_id"]
    robot.pass_s(8.0)
    assert robot.clients[1].ask("result", job_id=job)["result"]["outcome"] == "done"


@pytest.mark.study
def test_a_client_of_the_library_takes_its_jobs_along(robot: ServedRobot) -> None:
    with Client(robot.path) as client, robot.quick_checks():
        mine = client.submit(robot.jobs["round"])
    with Client(robot.path) as client, robot.quick_checks():
        detached = client.submit(robot.jobs["there"], detach=True)
    until(lambda: robot.controller.result(mine) is not None, "it is dropped")
    robot.pass_s(8.0)
    outcomes = [robot.controller.result(one).outcome for one in (mine, detached)]
    assert outcomes == ["cancelled", "done"]


def test_nothing_goes_on_when_the_check_ends_just_as_it_is_called_off(robot: ServedRobot) -> None:
    """The plan is ready, and its answer is not yet given."""
    for call_off in (robot.controller.cancel, robot.controller.power_off):
        number = robot.clients[0].send("run", job=str(robot.jobs["there"]))
        until(lambda: bool(robot.gates), "it is planned")
        with robot.controller.condition.lock:
            robot.gates[0].opened.set()
            with suppress(NotReady):
                call_off()
        assert not robot.clients[0].outcome(number)["ok"]
        _does_not_move(robot)
