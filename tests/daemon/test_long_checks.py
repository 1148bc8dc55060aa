"""A job whose check takes long is answered at once, and its client hears what came of it."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from deltactl.firmware_py.controller.states import State
from deltactl.firmware_py.daemon.client import Client
from deltactl.foundation.errors import ConfigError, DeltactlError, NotReady, UnreachablePoint
from tests.rigs.started import started
from tests.rigs.two_clients import ServedRobot, until


@pytest.fixture
def robot(tmp_path: Path) -> Iterator[ServedRobot]:
    """Homed; no check is waited for."""
    served = ServedRobot(tmp_path)
    assert served.clients[0].ask("on")["ok"]
    assert served.clients[0].ask("home", accept_unseen_deg=360.0)["ok"]
    yield served
    served.close()


@pytest.mark.study
def test_each_is_answered_before_its_check_ends(robot: ServedRobot) -> None:
    """The second too, which waits for the first; its result is asked for meanwhile."""
    first, second = (
        robot.clients[client].ask("run", job=str(robot.jobs[name]))
        for client, name in ((0, "there"), (1, "back"))
    )
    assert [one["planning"] for one in (first, second)] == [True, True]
    status = robot.clients[1].ask("status")["status"]
    assert status["planning_ids"] == [first["job_id"], second["job_id"]]
    assert robot.state is State.PLANNING
    for answer in (first, second):
        found = robot.clients[0].ask("result", job_id=answer["job_id"])
        assert (found["result"], found["planning"]) == (None, True)
    for _ in range(2):
        robot.let_check_end()
    until(lambda: "planning" not in robot.clients[0].ask("result", job_id=2), "both are queued")
    robot.pass_s(12.0)
    for answer in (first, second):
        found = robot.clients[0].ask("result", job_id=answer["job_id"])
        assert found["result"]["outcome"] == "done"
        assert "error" not in found


@pytest.mark.parametrize(
    ("change", "kind"),
    [(("-0.45]", "-4.5]"), UnreachablePoint), (("name: there", "nmae: there"), ConfigError)],
)
def test_a_late_refusal_is_raised_where_the_job_was_sent(
    robot: ServedRobot, change: tuple[str, str], kind: type[DeltactlError]
) -> None:
    wrong = robot.jobs["there"]
    wrong.write_text(wrong.read_text().replace(*change))
    with robot.quick_checks():
        with Client(robot.path) as client, pytest.raises(kind, match="there"):
            client.submit(wrong)
        ran = started("run", wrong, "--socket", robot.path)
        said = ran.communicate(timeout=120.0)[1]
    assert ran.returncode == 2
    assert "there" in said
    assert robot.state is State.READY
    until(lambda: robot.clients[0].ask("result", job_id=1)["result"] is not None, "it has ended")
    found = robot.clients[0].ask("result", job_id=1)
    assert found["result"]["outcome"] == "refused"
    assert found["error"]["kind"] == kind.__name__


@pytest.mark.study
def test_one_that_is_called_off_behind_another_is_refused_before_its_turn(
    robot: ServedRobot,
) -> None:
    robot.clients[0].ask("run", job=str(robot.jobs["there"]))
    raised: list[DeltactlError] = []

    def submit() -> None:
        with Client(robot.path) as client:
            try:
                client.submit(robot.jobs["back"])
            except DeltactlError as error:
                raised.append(error)

    waiting = threading.Thread(target=submit)
    waiting.start()
    until(lambda: len(robot.controller.jobs.planned) == 2, "both are accepted")
    assert robot.clients[1].ask("cancel", job_id=2)["ok"]
    waiting.join(60.0)
    assert not waiting.is_alive()
    assert [type(error) for error in raised] == [NotReady]
    assert len(robot.gates) == 1  # the first is being planned all the time
    robot.let_check_end()
    robot.pass_s(8.0)
    assert robot.clients[0].ask("result", job_id=1)["result"]["outcome"] == "done"
    assert robot.clients[0].ask("result", job_id=2)["result"]["outcome"] == "cancelled"


def test_too_many_jobs_that_wait_for_their_check_are_refused(robot: ServedRobot) -> None:
    answers = [robot.clients[0].ask("run", job=str(robot.jobs["there"])) for _ in range(40)]
    taken = [one for one in answers if one["ok"]]
    assert 0 < len(taken) < 40
    assert {one["error"]["kind"] for one in answers if not one["ok"]} == {"NotReady"}
    assert robot.clients[0].ask("cancel")["ok"]
    until(lambda: robot.state is State.READY, "all are dropped")
    again = robot.clients[0].ask("run", job=str(robot.jobs["there"]))
    assert again["ok"], again
