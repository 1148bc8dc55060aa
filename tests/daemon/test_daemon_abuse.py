"""Clients that hang, flood or send rubbish: they hurt nobody but themselves."""

from __future__ import annotations

import contextlib
import errno
import json
import logging
import socket
import threading
import time

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.firmware_py.daemon.client import Client
from deltactl.firmware_py.daemon.limits import Allowance, Limits, Lines
from deltactl.firmware_py.daemon.protocol import (
    ARGUMENTS,
    MAX_LINE_BYTES,
    BadRequest,
    encode,
    parse,
)
from deltactl.foundation.errors import NotReady, ServiceError

RUBBISH = [
    (b"hello", "one JSON object a line"),
    (b"\xff\xfe\x00", "one JSON object a line"),
    (b"[" * 50_000, "one JSON object a line"),
    (b"9" * 10_000, "one JSON object a line"),
    (b'"status"', "must be a JSON object"),
    (b"{}", "'do' cannot be None; there are ping"),
    (b'{"id": 1, "do": "statsu"}', "'do' cannot be 'statsu'; did you mean 'status'?"),
    (b'{"id": 1, "do": ["run"]}', "'do' cannot be"),
    (b'{"id": [], "do": "status"}', "'id' must be"),
    (b'{"id": 1, "do": "run", "jbo": "/a.yaml"}', "did you mean 'job'?"),
    (b'{"id": 1, "do": "run", "job": 3}', "'job' of 'run' must be a plain text"),
    (b'{"id": 1, "do": "run", "job": "/a\\u0000.yaml"}', "must be a plain text"),
    (b'{"id": 1, "do": "run", "job": "/\\ud800.yaml"}', "must be a plain text"),
    (b'{"id": 1, "do": "run"}', "needs either 'job'"),
    (b'{"id": 1, "do": "watch", "rate_hz": 1000}', "must be 0.01 to 20"),
    (b'{"id": 1, "do": "watch", "rate_hz": true}', "must be a number"),
    (b'{"id": 1, "do": "watch", "rate_hz": NaN}', "must be 0.01 to 20"),
    (b'{"id": 1, "do": "result", "job_id": 1.5}', "must be a number"),
    (b'{"id": 1, "do": "result"}', "knows no job None"),
]


@pytest.mark.parametrize(("line", "complaint"), RUBBISH)
def test_rubbish_gets_one_line_and_keeps_the_connection(serve, line, complaint):
    raw = serve().raw()
    raw.send(line + b"\n")
    answer = raw.receive()
    assert answer["ok"] is False
    assert complaint in answer["error"]["message"]
    assert "\n" not in answer["error"]["message"]
    assert raw.ask(id=2, do="ping")["id"] == 2


def test_a_request_that_is_too_long_is_refused_once(serve):
    raw = serve().raw()
    raw.send(b"x" * (3 * MAX_LINE_BYTES) + b'\n{"id": 2, "do": "ping"}\n')
    assert "64 kB at most" in raw.receive()["error"]["message"]
    assert raw.receive()["id"] == 2


def test_a_flood_is_slowed_and_others_do_not_notice(serve):
    daemon = serve(Limits(requests_hz=50.0, burst=20, refusals=300, slow_down_s=0.02))
    daemon.raw()  # hangs, says nothing at all
    flood = daemon.raw()
    end, served = threading.Event(), []
    start_s = time.monotonic()

    def pour() -> None:
        with contextlib.suppress(OSError):
            while not end.is_set():
                flood.send(b'{"id": 1, "do": "status"}\n' * 200)

    def drain() -> None:
        with contextlib.suppress(OSError, ValueError):
            while (answer := flood.receive()) is not None:
                served.append(answer["ok"])

    threads = [threading.Thread(target=pour), threading.Thread(target=drain)]
    for thread in threads:
        thread.start()
    with daemon.client() as client:
        between = []  # requests of the flood that are served before one of another client's
        for _ in range(40):
            before = sum(served)
            client.status()
            between.append(sum(served) - before)
            time.sleep(0.01)
    end.set()
    flood.socket.shutdown(socket.SHUT_RDWR)
    for thread in threads:
        thread.join(30.0)
    assert sorted(between)[len(between) // 2] <= 2  # others have their turn,
    assert len(served) > sum(served)  # some were refused,
    assert sum(served) <= 20 + 50.0 * (time.monotonic() - start_s)  # the rest kept to the rate


def test_a_flood_is_cut_off_in_the_end(serve):
    raw = serve(Limits(requests_hz=10.0, burst=5, refusals=20, slow_down_s=0.01)).raw()
    with contextlib.suppress(OSError):
        for _ in range(60):
            raw.send(b'{"id": 1, "do": "ping"}\n')
    answers = []
    with contextlib.suppress(ConnectionResetError):
        while (answer := raw.receive()) is not None:
            answers.append(answer)
    assert sum(answer["ok"] for answer in answers) < 10
    assert "more than 10 requests a second" in answers[-2]["error"]["message"]
    assert "connection is closed" in answers[-1]["error"]["message"]


def test_a_client_that_does_not_read_is_cut_off(serve, wait_until):
    daemon = serve(Limits(waiting_answers=8, send_s=0.2, burst=10_000, refusals=10_000))
    deaf = daemon.raw()
    deaf.socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)

    def cut_off() -> bool:
        try:
            deaf.send(b'{"id": 1, "do": "status"}\n' * 10)
        except OSError:
            return True
        return False

    wait_until(cut_off)
    with daemon.client() as client:
        assert client.status().state == "off"


def test_a_flooder_that_leaves_without_reading_does_not_keep_its_place(serve, wait_until):
    """Its many requests were not answered one time-out after the other, but a stop was heard."""
    daemon = serve(Limits(clients=1, stop_only_clients=0, waiting_answers=2, send_s=0.2))
    flood = daemon.raw()
    with contextlib.suppress(OSError):
        flood.send(b'{"id": 1, "do": "status"}\n' * 150 + b'{"id": 2, "do": "stop"}\n')
    flood.close()

    def has_place() -> bool:
        with contextlib.suppress(ServiceError), daemon.client() as client:
            return client.progress_count() > 0
        return False

    wait_until(has_place)
    assert daemon.controller.calls[-1] == "stop"


def test_half_a_line_is_waited_for_and_then_not(serve):
    raw = serve(Limits(half_line_s=0.3)).raw()
    raw.send(b'{"id": 1, "do"')
    time.sleep(0.1)
    raw.send(b': "ping"}\n{"id"')
    assert raw.receive()["id"] == 1
    assert "did not come" in raw.receive()["error"]["message"]
    assert raw.receive() is None


def test_idle_clients_are_let_go_but_watchers_are_not(serve):
    daemon = serve(Limits(idle_s=0.3))
    idle, watcher = daemon.raw(), daemon.raw()
    watcher.ask(id=1, do="watch", rate_hz=5)
    assert "nothing was asked" in idle.receive()["error"]["message"]
    assert idle.receive() is None
    assert watcher.receive()["status"]["state"] == "off"
    assert watcher.receive()["status"]["state"] == "off"


def test_when_all_places_are_taken_a_stop_still_gets_in(serve, wait_until):
    daemon = serve(Limits(clients=2, stop_only_clients=1, stop_only_idle_s=0.3))
    for _ in range(2):
        daemon.raw().ask(id=1, do="ping")
    late = daemon.raw()
    assert "only 'stop'" in late.ask(id=1, do="status")["error"]["message"]
    turned_away = daemon.raw()
    assert "too many clients" in turned_away.receive()["error"]["message"]
    assert late.ask(id=2, do="stop") == {"id": 2, "ok": True}
    assert daemon.controller.calls == ["stop"]
    wait_until(lambda: late.receive() is None)


def test_places_become_free_again(serve, wait_until):
    daemon = serve(Limits(clients=1, stop_only_clients=0))
    daemon.raw().ask(id=1, do="ping")
    daemon._opened[0].close()

    def let_in() -> bool:
        with contextlib.suppress(OSError):
            return daemon.raw().ask(id=1, do="ping")["ok"]
        return False

    wait_until(let_in)


def test_a_stop_overtakes_a_home_on_the_same_connection(serve, wait_until):
    daemon = serve()
    daemon.controller.let_go.clear()
    raw = daemon.raw()
    raw.ask(id=0, do="on")
    raw.send(b'{"id": 1, "do": "home"}\n{"id": 2, "do": "acknowledge"}\n')
    wait_until(lambda: "home" in daemon.controller.calls)
    raw.send(b'{"id": 3, "do": "stop"}\n')
    answers = {answer["id"]: answer for answer in (raw.receive(), raw.receive())}
    daemon.controller.let_go.set()  # both answers came while it was homing
    assert answers[3]["ok"] is True
    # The acknowledge came before the stop and must not undo it afterwards.
    assert answers[2]["ok"] is False
    assert raw.receive()["id"] == 1
    assert daemon.controller.state.value == "stopped"


def test_a_stop_overtakes_another_clients_slow_check(serve, job):
    daemon = serve()
    with daemon.client() as slow, daemon.client() as quick:
        slow.power_on()
        slow.home()
        daemon.controller.let_go.clear()
        refused: list[str] = []

        def submit() -> None:
            try:
                slow.submit(job)
            except NotReady as error:
                refused.append(str(error))

        running = threading.Thread(target=submit)
        running.start()
        quick.stop("now")
        assert quick.status().state == "stopped"
        daemon.controller.let_go.set()  # the check was not over
        running.join()
    assert len(refused) == 1
    assert daemon.controller.jobs == []


def test_commands_of_a_client_that_has_gone_are_not_begun(serve, wait_until):
    daemon = serve()
    daemon.controller.let_go.clear()
    with daemon.client() as client:
        client.power_on()
        homing = daemon.raw()
        homing.send(b'{"id": 1, "do": "home"}\n')
        gone = daemon.raw()
        gone.send(b'{"id": 1, "do": "home"}\n')
        time.sleep(0.1)
        gone.close()
        time.sleep(0.1)
        daemon.controller.let_go.set()
        answer = homing.receive()
        assert (answer["id"], answer["ok"]) == (1, True)
        wait_until(lambda: client.status().state == "ready")
        client.home()  # behind the dropped command
    assert daemon.controller.calls == ["on", "home", "home"]


def test_too_many_waiting_commands_are_refused(serve, wait_until):
    daemon = serve(Limits(waiting_commands=2))
    daemon.controller.let_go.clear()
    raw = daemon.raw()
    raw.ask(id=0, do="on")
    raw.send(b'{"id": 1, "do": "home"}\n')
    wait_until(lambda: "home" in daemon.controller.calls)
    raw.send(b'{"id": 2, "do": "home"}\n' * 2 + b'{"id": 3, "do": "home"}\n')
    answer = raw.receive()
    assert answer["id"] == 3
    daemon.controller.let_go.set()
    assert "2 commands are waiting" in answer["error"]["message"]


def test_the_log_has_one_line_of_why_a_request_was_refused(serve, caplog):
    raw = serve().raw()
    caplog.set_level(logging.INFO)
    caplog.clear()
    answer = raw.ask(id=1, do="run", job="/nowhere/a.yaml")
    said = [one.getMessage() for one in caplog.records]
    assert len([line for line in said if answer["error"]["message"] in line]) == 1


def test_a_mistake_of_ours_is_said_and_the_daemon_goes_on(serve, monkeypatch, caplog):
    daemon = serve()
    monkeypatch.setattr(daemon.controller, "progress_count", lambda: 1 / 0)
    raw = daemon.raw()
    answer = raw.ask(id=1, do="ping")
    assert answer["error"]["kind"] == "ServiceError"
    assert "failed inside (ZeroDivisionError" in answer["error"]["message"]
    assert raw.ask(id=2, do="version")["ok"] is True
    assert "ZeroDivisionError" in caplog.text


def test_nothing_is_begun_while_the_daemon_ends(serve):
    daemon = serve()
    daemon.server.end_commands()
    with daemon.client() as client:
        with pytest.raises(NotReady, match="the daemon is ending"):
            client.power_on()
        client.stop()
        assert client.status().state == "stopped"


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=30),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=9), inner),
    max_leaves=12,
)


@pytest.mark.study
@settings(max_examples=150, deadline=None)
@given(
    st.binary(max_size=300)
    | st.dictionaries(
        st.sampled_from(["id", "do", *{name for known in ARGUMENTS.values() for name in known}]),
        JSON | st.sampled_from(list(ARGUMENTS)),
    ).map(lambda message: json.dumps(message).encode())
)
def test_any_line_is_a_request_or_a_refusal_that_can_be_sent(line):
    try:
        answer = {"id": parse(line).id}
    except BadRequest as error:
        answer = error.answer
    assert encode(answer).count(b"\n") == 1


@settings(max_examples=100, deadline=None)
@given(st.lists(st.binary(max_size=30) | st.just(b"\n"), max_size=12))
def test_lines_are_cut_the_same_however_they_arrive(parts):
    whole = b"".join(parts)
    pieces = Lines(20)
    found = [line for part in parts for line in pieces.feed(part)]
    ends = whole.split(b"\n")[:-1]
    expected = [line if len(line) <= 20 else None for line in ends if line.strip()]
    rest = whole.rsplit(b"\n", 1)[-1]
    assert found == expected + ([None] if len(rest) > 20 else [])


def test_an_allowance_refills_at_its_rate():
    allowance = Allowance(rate_hz=100.0, burst=5)
    assert [allowance.take() for _ in range(7)].count(True) == 5
    time.sleep(0.035)
    assert 3 <= [allowance.take() for _ in range(10)].count(True) <= 5


def test_a_client_waits_its_turn_when_many_knock(serve):
    """The kernel lets 129 wait at the door; the next one is told to try again, and does."""
    daemon = serve(start=False)
    crowd = []
    full = False
    while not full:
        crowd.append(socket.socket(socket.AF_UNIX, socket.SOCK_STREAM))
        crowd[-1].setblocking(False)
        full = crowd[-1].connect_ex(str(daemon.path)) == errno.EAGAIN
    with pytest.raises(ServiceError, match="no connection to the daemon"):
        Client(daemon.path, quick_s=0.05)
    for one in crowd:
        one.close()
    starting = threading.Timer(0.1, daemon.server.start)
    starting.start()
    with daemon.client() as client:
        assert client.status().state == "off"
    starting.join()
