"""Signing in, and what the guard before the pages turns away, each in one line."""

from __future__ import annotations

import http.client
import logging
import os
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

import pytest
import uvicorn
from fastapi import FastAPI, Request, WebSocket
from starlette.responses import PlainTextResponse, Response
from starlette.testclient import TestClient
from starlette.websockets import WebSocketDisconnect

from deltactl.foundation.errors import ConfigError
from deltactl.web.access.guard import MAX_BODY, Guard
from deltactl.web.access.login import add_login
from deltactl.web.access.users import (
    LASTS_S,
    SCRYPT,
    Sessions,
    Users,
    add_user,
    load_users,
    right,
)
from deltactl.web.serve import Where, not_cut_off, serve

HERE = "http://127.0.0.1:8080"
WS = "ws://127.0.0.1:8080/ws"
PASSWORD = "correct horse battery"
SHIPPED = dict(SCRYPT)
pytestmark = pytest.mark.usefixtures("quick_hashes")


@pytest.fixture(scope="module")
def users_file(tmp_path_factory: pytest.TempPathFactory, quick_hashes: None) -> Path:
    path = tmp_path_factory.mktemp("who") / "users.yaml"
    add_user(path, "ada", "operator", PASSWORD)
    add_user(path, "hall", "viewer", PASSWORD + "!")
    return path


def guarded(users: Path | None, lasts_s: float = LASTS_S, **more: object) -> Guard:
    """A small application behind the guard."""
    app = FastAPI()

    @app.get("/")
    def page(request: Request) -> Response:
        session = request.scope["deltactl"]
        return PlainTextResponse(f"{session.name} {session.role}")

    @app.post("/do")
    async def do(request: Request) -> Response:
        return PlainTextResponse(str(len(await request.body())))

    @app.websocket("/ws")
    async def socket(websocket: WebSocket) -> None:
        await websocket.accept()
        with suppress(WebSocketDisconnect):
            while True:
                await websocket.send_text(await websocket.receive_text())

    if users is None:
        return Guard(app, None, **more)  # type: ignore[arg-type]
    known = Users(users)
    sessions = Sessions(known, lasts_s)
    add_login(app, known, sessions, secure=False)
    return Guard(app, sessions, **more)  # type: ignore[arg-type]


def browser(guard: Guard, address: str = "127.0.0.1") -> TestClient:
    return TestClient(guard, base_url=HERE, follow_redirects=False, client=(address, 50_000))


def sign_in(one: TestClient, name: str, password: str = PASSWORD) -> int:
    return one.post("/login", data={"name": name, "password": password}).status_code


def test_on_this_machine_nobody_signs_in() -> None:
    assert browser(guarded(None)).get("/").text == " operator"


def test_on_a_network_somebody_has_to(users_file: Path) -> None:
    one = browser(guarded(users_file))
    assert one.get("/").headers["location"] == "/login"
    assert one.post("/do").status_code == 401
    wrong = one.post("/login", data={"name": "ada", "password": "x"})
    assert (wrong.status_code, "wrong" in wrong.text) == (401, True)
    good = one.post("/login", data={"name": "ada", "password": PASSWORD})
    given = good.headers["set-cookie"]
    assert good.headers["location"] == "/"
    assert "HttpOnly" in given
    assert "SameSite=Strict" in given
    assert one.get("/").text == "ada operator"
    one.post("/logout")
    assert one.get("/").status_code == 303


def test_a_session_ends_by_itself_under_an_open_page(users_file: Path) -> None:
    one = browser(guarded(users_file, lasts_s=0.6))
    one.post("/login", data={"name": "hall", "password": PASSWORD + "!"})
    assert one.get("/").text == "hall viewer"
    with one.websocket_connect(WS) as socket:
        socket.send_text("x")
        assert socket.receive_text() == "x"
        time.sleep(0.7)
        socket.send_text("y")
        with pytest.raises(WebSocketDisconnect):
            socket.receive_text()
    assert one.get("/").status_code == 303
    assert LASTS_S <= 12 * 3600


def test_guessing_is_slow_and_keeps_nobody_out_who_is_elsewhere(
    users_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("deltactl.web.access.login.ADDRESS_HZ", 1e-6)
    monkeypatch.setattr("deltactl.web.access.login.USER_HZ", 1e-6)
    guard = guarded(users_file)
    guesser, owner = browser(guard, "192.0.2.66"), browser(guard, "192.0.2.1")
    said = [sign_in(guesser, "ada", "x") for _ in range(9)]
    assert said == [401] * 6 + [429] * 3, "of one user"
    said = [sign_in(guesser, f"user{number}", "x") for number in range(9)]
    assert said == [401] * 3 + [429] * 6, "of many names from one address"
    assert sign_in(guesser, "hall", PASSWORD + "!") == 429
    assert sign_in(owner, "ada") == 303


def test_one_network_of_ipv6_is_one_guesser(
    users_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("deltactl.web.access.login.ADDRESS_HZ", 1e-6)
    guard = guarded(users_file)
    said = [sign_in(browser(guard, f"2001:db8::{number:x}"), f"u{number}", "x")
            for number in range(13)]  # fmt: skip
    assert said == [401] * 12 + [429]


def test_who_signs_in_rightly_may_do_so_as_often_as_they_like(users_file: Path) -> None:
    one = browser(guarded(users_file))
    assert {sign_in(one, "ada") for _ in range(15)} == {303}


def test_changed_users_are_in_force_at_the_next_request(tmp_path: Path) -> None:
    file = tmp_path / "users.yaml"
    for name, role in (("ada", "operator"), ("eve", "operator"), ("hall", "viewer")):
        add_user(file, name, role, PASSWORD)  # type: ignore[arg-type]
    guard = guarded(file)
    ada, eve, hall = (browser(guard) for _ in range(3))
    for one, name in ((ada, "ada"), (eve, "eve"), (hall, "hall")):
        assert sign_in(one, name) == 303
    with ada.websocket_connect(WS) as open_page:
        open_page.send_text("x")
        assert open_page.receive_text() == "x"
        add_user(file, "ada", "operator", "another password")
        add_user(file, "eve", "viewer", PASSWORD)
        add_user(file, "new", "viewer", PASSWORD)
        open_page.send_text("y")
        with pytest.raises(WebSocketDisconnect):
            open_page.receive_text()
    assert (ada.get("/").status_code, eve.get("/").status_code) == (303, 303), "changed"
    assert hall.get("/").text == "hall viewer", "unchanged"
    assert sign_in(ada, "ada") == 401
    assert sign_in(ada, "ada", "another password") == 303
    assert sign_in(eve, "eve") == 303
    assert eve.get("/").text == "eve viewer"
    assert sign_in(browser(guard), "new") == 303


def test_a_removed_user_is_out_and_a_broken_file_keeps_those_who_are_in(tmp_path: Path) -> None:
    file = tmp_path / "users.yaml"
    add_user(file, "hall", "viewer", PASSWORD)
    only_hall = file.read_text()
    add_user(file, "ada", "operator", PASSWORD)
    guard = guarded(file)
    ada, hall = browser(guard), browser(guard)
    assert (sign_in(ada, "ada"), sign_in(hall, "hall")) == (303, 303)
    file.write_text(only_hall)
    assert (ada.get("/").status_code, hall.get("/").status_code) == (303, 200)
    file.write_text("users: [")
    assert hall.get("/").status_code == 200
    assert sign_in(browser(guard), "hall") == 503
    file.write_text(only_hall)
    assert sign_in(browser(guard), "hall") == 303


def test_nobody_ends_the_sessions_of_others_by_signing_in_often(users_file: Path) -> None:
    guard = guarded(users_file)
    ada, hall = browser(guard), browser(guard)
    sign_in(ada, "ada")
    for _ in range(25):
        sign_in(hall, "hall", PASSWORD + "!")
    assert ada.get("/").text == "ada operator"


def test_a_page_is_built_for_a_browser_that_goes_to_it_and_for_nothing_else() -> None:
    one = browser(guarded(None))
    goes = {"sec-fetch-mode": "navigate", "sec-fetch-dest": "document"}
    assert one.get("/", headers={**goes, "sec-fetch-site": "cross-site"}).status_code == 200
    for other in (
        {"sec-fetch-mode": "no-cors", "sec-fetch-dest": "image"},
        {"sec-fetch-mode": "cors", "sec-fetch-dest": "empty"},
        {"sec-fetch-mode": "navigate", "sec-fetch-dest": "iframe"},
        {**goes, "sec-purpose": "prefetch;prerender"},
    ):
        assert one.get("/", headers=other).status_code == 403


def test_pages_are_built_so_often_for_one_address(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("deltactl.web.access.guard.BUILD_HZ", 1e-6)
    guard = guarded(None)
    said = [browser(guard).get("/").status_code for _ in range(40)]
    assert said == [200] * 30 + [429] * 10
    assert browser(guard, "192.0.2.1").get("/").status_code == 200


def test_one_address_cannot_take_all_pages() -> None:
    guard = guarded(None)
    greedy, other = browser(guard, "192.0.2.66"), browser(guard, "192.0.2.1")
    with ExitStack() as pages:
        for _ in range(30):
            pages.enter_context(greedy.websocket_connect(WS))
        with pytest.raises(WebSocketDisconnect), greedy.websocket_connect(WS):
            pass
        with other.websocket_connect(WS) as socket:
            socket.send_text("x")
            assert socket.receive_text() == "x"


@pytest.mark.parametrize(
    "headers",
    [
        {"origin": "http://evil.example"},
        {"origin": "null"},
        {"origin": "http://127.0.0.1:9999"},
        {"sec-fetch-site": "cross-site"},
    ],
)
def test_other_sites_pages_can_do_nothing(headers: dict[str, str]) -> None:
    one = browser(guarded(None))
    assert one.post("/do", headers=headers).status_code == 403
    with pytest.raises(WebSocketDisconnect) as refused, one.websocket_connect(WS, headers=headers):
        pass
    assert "another site" in refused.value.reason
    assert one.post("/do", headers={"origin": HERE}).status_code == 200


def test_a_name_that_was_bent_to_this_machine_is_refused() -> None:
    answer = browser(guarded(None)).get("/", headers={"host": "evil.example"})
    assert answer.status_code == 403
    assert answer.text.count("\n") == 1


@pytest.mark.parametrize(
    "make",
    [
        lambda one: one.post("/do", content=b"x" * (MAX_BODY + 1)),
        lambda one: one.post("/do", headers={"content-length": "9" * 30}, content=b"x"),
        lambda one: one.post("/do", content=(b"x" * 4096 for _ in range(100))),
    ],
)
def test_a_giant_upload_is_refused(make: Callable[[TestClient], object]) -> None:
    answer = make(browser(guarded(None)))
    assert answer.status_code == 413  # type: ignore[attr-defined]


def test_what_is_not_too_long_arrives_whole() -> None:
    answer = browser(guarded(None)).post("/do", content=(b"x" * 4096 for _ in range(32)))
    assert answer.text == str(MAX_BODY)


@contextmanager
def served(config: uvicorn.Config) -> Iterator[tuple[uvicorn.Server, threading.Thread, int]]:
    """A server over a real connection, the thread it runs in, and its port; ended afterwards."""
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run)
    thread.start()
    try:
        while not server.started:
            time.sleep(0.01)
        yield server, thread, server.servers[0].sockets[0].getsockname()[1]
    finally:
        server.should_exit = True
        thread.join(30.0)


def test_who_sends_too_much_hears_why_and_not_a_broken_pipe() -> None:
    """Over a real connection: megabytes are still on their way when the answer is known."""
    config = uvicorn.Config(guarded(None), port=0, log_level="critical", lifespan="off")
    with served(config) as (_, _, port):
        for _ in range(3):
            asked = http.client.HTTPConnection("127.0.0.1", port, timeout=30.0)
            asked.request("POST", "/do", body=b"x" * 8_000_000)
            answer = asked.getresponse()
            assert (answer.status, answer.read()) == (413, b"more than 128 kB are not taken\n")
            asked.close()


def test_of_fifty_clients_forty_get_a_page_and_ten_a_line() -> None:
    guard = guarded(None)
    one = browser(guard)
    with ExitStack() as pages:
        for number in range(40):
            other = browser(guard, f"192.0.2.{number}")
            pages.enter_context(other.websocket_connect(WS))
        for _ in range(10):
            with pytest.raises(WebSocketDisconnect) as refused, one.websocket_connect(WS):
                pass
            assert "40 pages are open already" in refused.value.reason
        assert one.get("/health").status_code == 404  # this small application has none
    with one.websocket_connect(WS) as socket:
        socket.send_text("x")
        assert socket.receive_text() == "x"


def test_too_many_requests_and_too_many_pages_are_told_so(monkeypatch: pytest.MonkeyPatch) -> None:
    one = browser(guarded(None, max_pages=2))
    with one.websocket_connect(WS), one.websocket_connect(WS):
        assert one.get("/").status_code == 503
        assert "open already" in one.get("/").text
        with pytest.raises(WebSocketDisconnect), one.websocket_connect(WS):
            pass
    assert one.get("/").status_code == 200
    monkeypatch.setattr("deltactl.web.access.guard.REQUESTS_HZ", 0.01)
    monkeypatch.setattr("deltactl.web.access.guard.REQUESTS_BURST", 3)
    hasty = browser(guarded(None))
    assert [hasty.get("/").status_code for _ in range(4)] == [200, 200, 200, 429]


def test_what_the_end_of_the_service_cuts_off_is_one_line(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """A request that still sends its body when the service ends."""
    said: list[str] = []

    class Said(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            said.append(self.format(record))

    log, handler = logging.getLogger("uvicorn.error"), Said()
    config = uvicorn.Config(
        guarded(None), port=0, log_level="error", lifespan="off", timeout_graceful_shutdown=0
    )
    log.addFilter(not_cut_off)
    log.addHandler(handler)
    try:
        with (
            served(config) as (server, thread, port),
            socket.create_connection(("127.0.0.1", port)) as one,
        ):
            head = f"POST /do HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nContent-Length: 9\r\n\r\nabc"
            one.sendall(head.encode())
            while not server.server_state.tasks:
                time.sleep(0.01)
            server.should_exit = True
            thread.join(30.0)
    finally:
        log.removeFilter(not_cut_off)
        log.removeHandler(handler)
    assert len(said) == 1
    assert said[0].startswith("Cancel 1 running task")
    assert "Traceback" not in capsys.readouterr().err


def test_a_guess_costs_memory_and_time() -> None:
    """No less than the OWASP Password Storage Cheat Sheet (2024) asks of a hash of 16 MB."""
    assert 128 * SHIPPED["n"] * SHIPPED["r"] >= 2**24
    assert SHIPPED["n"] * SHIPPED["p"] >= 5 * 2**14


def test_the_file_holds_hashes_and_only_the_service_reads_it(users_file: Path) -> None:
    text = users_file.read_text()
    assert PASSWORD not in text
    assert users_file.stat().st_mode & 0o777 == 0o600
    users = Users(users_file)
    assert right(users.get("ada"), PASSWORD) is users.get("ada")
    assert right(users.get("ada"), PASSWORD + "!") is None
    assert right(users.get("nobody"), PASSWORD) is None
    os.chmod(users_file, 0o640)
    with pytest.raises(ConfigError, match="chmod 600"):
        load_users(users_file)
    os.chmod(users_file, 0o600)
    with pytest.raises(ConfigError, match="characters at least"):
        add_user(users_file, "eve", "viewer", "short")


def test_no_network_without_users(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="web user"):
        serve(Where("0.0.0.0", 8080, None, tmp_path, tmp_path / "w"))
