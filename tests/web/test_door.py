"""Silent and slow connections: they keep the page from nobody. Over real connections."""

from __future__ import annotations

import http.client
import socket
import ssl
import subprocess
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path

import pytest
import uvicorn
from fastapi import FastAPI, WebSocket
from starlette.responses import PlainTextResponse, Response
from websockets.sync.client import connect

from deltactl.foundation.errors import ConfigError
from deltactl.web.access.door import MOST, Door, listen, protocol_of
from deltactl.web.access.guard import Guard

HALF = b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX-Slow: "
WHOLE = b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"
BODY = b"POST /do HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 9\r\n\r\nabc"
SHORT_S = 0.6


def application() -> FastAPI:
    app = FastAPI()

    @app.get("/")
    def page() -> Response:
        return PlainTextResponse("the page")

    @app.websocket("/ws")
    async def echo(websocket: WebSocket) -> None:
        await websocket.accept()
        async for text in websocket.iter_text():
            await websocket.send_text(text)

    return app


@contextmanager
def served(door: Door, **more: object) -> Iterator[int]:
    """The application behind a door and the guard; its port."""
    sockets = listen("127.0.0.1", 0, door)
    port = int(sockets[0].getsockname()[1])
    config = uvicorn.Config(
        Guard(application()), http=protocol_of(door), loop="asyncio", log_level="critical",
        lifespan="off", timeout_graceful_shutdown=1, **more,
    )  # type: ignore[arg-type] # fmt: skip
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run, args=(sockets,))
    thread.start()
    try:
        while not server.started:
            time.sleep(0.01)
        yield port
    finally:
        server.should_exit = True
        thread.join(30.0)


def silent(port: int, says: bytes = b"", source: str = "127.0.0.1") -> socket.socket:
    one = socket.create_connection(("127.0.0.1", port), 5.0, source_address=(source, 0))
    one.sendall(says)
    return one


def asks(port: int, source: str = "127.0.0.1") -> str:
    one = http.client.HTTPConnection("127.0.0.1", port, 5.0, source_address=(source, 0))
    with closing(one):
        one.request("GET", "/")
        return one.getresponse().read().decode()


def ended(one: socket.socket, within_s: float) -> bool:
    """Whether the other side has closed a connection."""
    one.settimeout(within_s)
    try:
        while one.recv(4096):
            pass
    except TimeoutError:
        return False
    except ConnectionResetError:
        return True
    return True


@pytest.mark.parametrize("says", [b"", HALF])
def test_420_silent_connections_keep_the_page_from_nobody(says: bytes) -> None:
    with served(Door()) as port, ExitStack() as held:
        for _ in range(420):
            held.enter_context(silent(port, says))
        began_s = time.monotonic()
        assert asks(port) == "the page"
        assert asks(port, "127.0.0.2") == "the page"
        assert time.monotonic() - began_s < 4.0


def test_silent_connections_from_many_addresses_make_room_too() -> None:
    with served(Door(most=40, each=10)) as port, ExitStack() as held:
        for number in range(60):
            held.enter_context(silent(port, source=f"127.0.1.{number + 1}"))
        assert asks(port, "127.0.0.2") == "the page"


def test_one_address_has_so_many_connections_and_another_its_own() -> None:
    """Connections that are in the middle of a request make no room: others keep theirs."""
    door = Door(most=40, each=4)
    with served(door) as port, ExitStack() as held:
        for _ in range(4):
            held.enter_context(silent(port, BODY))
        time.sleep(0.3)
        assert ended(held.enter_context(silent(port)), 5.0)
        assert asks(port, "127.0.0.2") == "the page"
        held.close()
        give_up_s = time.monotonic() + 5.0
        while len(door) and time.monotonic() < give_up_s:
            time.sleep(0.02)
        assert len(door) == 0, "each that is closed makes its place free"
        assert asks(port) == "the page"


@pytest.mark.parametrize("says", [b"", HALF, WHOLE + HALF])
def test_a_head_that_does_not_come_to_its_end_is_not_waited_for(says: bytes) -> None:
    with served(Door(request_s=SHORT_S), timeout_keep_alive=60) as port, silent(port, says) as one:
        for _ in range(int(says != b"") * 12):
            time.sleep(0.1)
            try:
                one.sendall(b"x")
            except OSError:
                break
        assert ended(one, 5.0)


def test_a_websocket_may_be_silent() -> None:
    with served(Door(request_s=SHORT_S)) as port, connect(f"ws://127.0.0.1:{port}/ws") as one:
        time.sleep(2 * SHORT_S)
        one.send("still here")
        assert one.recv(5.0) == "still here"


def test_a_body_that_does_not_come_is_not_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("deltactl.web.access.guard.BODY_S", SHORT_S)
    with served(Door()) as port, silent(port, BODY) as one:
        one.settimeout(5.0)
        assert b" 408 " in one.recv(4096).splitlines()[0]


def test_silent_connections_before_the_handshake_of_tls_count_as_well(tmp_path: Path) -> None:
    key, certificate = tmp_path / "page.key", tmp_path / "page.pem"
    subprocess.run(
        ["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-subj", "/CN=robot",
         "-keyout", str(key), "-out", str(certificate)],
        check=True, capture_output=True,
    )  # fmt: skip
    trust = ssl.create_default_context(cafile=str(certificate))
    trust.check_hostname = False
    door = Door(most=30, each=20, request_s=SHORT_S)
    with (
        served(door, ssl_certfile=certificate, ssl_keyfile=key) as port,
        ExitStack() as held,
    ):
        lot = [held.enter_context(silent(port)) for _ in range(25)]
        one = http.client.HTTPSConnection("127.0.0.1", port, timeout=5.0, context=trust)
        with closing(one):
            one.request("GET", "/")
            assert one.getresponse().read() == b"the page"
        assert all(ended(each, 5.0) for each in lot)


def test_a_port_that_is_taken_is_one_line() -> None:
    door = Door()
    with listen("127.0.0.1", 0, door)[0] as taken:
        port = taken.getsockname()[1]
        with pytest.raises(
            ConfigError, match=rf"cannot serve on 127\.0\.0\.1, port {port}.*--port"
        ):
            listen("127.0.0.1", port, door)
    assert MOST < 1000, "well below the descriptors that a process has"
