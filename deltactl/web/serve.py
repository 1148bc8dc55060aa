"""Serves the page: NiceGUI in a FastAPI application under uvicorn."""

from __future__ import annotations

import asyncio
import logging
import os
import signal
import sys
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import uvicorn
from fastapi import FastAPI, Request
from nicegui import core, ui
from starlette.responses import FileResponse, PlainTextResponse, Response

from deltactl.foundation.errors import ConfigError, DeltactlError, NotReady
from deltactl.web.access.door import Door, listen, protocol_of
from deltactl.web.access.guard import LOCAL, MAX_BODY, UPLOAD, Guard
from deltactl.web.access.login import add_login
from deltactl.web.access.pages import BuiltPages, FilesOfPages, judge_messages, nothing_here
from deltactl.web.access.policy import put_into_pages
from deltactl.web.access.tokens import Tokens
from deltactl.web.access.users import Session, Sessions, Users, operates
from deltactl.web.api import PLACE, make_api
from deltactl.web.behind.known_robots import KnownRobots
from deltactl.web.behind.link import DaemonLink
from deltactl.web.behind.site import HiddenFault, Site
from deltactl.web.page import RobotPage
from deltactl.web.style import KNOWN

TITLE = "deltactl"
RECONNECT_S = 8.0
LOOKS = "you are signed in to look, not to operate"
REPORT_HEADERS = {"Content-Security-Policy": "sandbox allow-scripts allow-downloads"}
"""A report runs its own charts, and is nobody to the page that shows it."""


APP_FOLDER = Path(__file__).parent / "app"
APP = {
    "manifest.webmanifest": "application/manifest+json",
    "icon-192.png": "image/png",
    "icon-512.png": "image/png",
}
"""What a phone needs to install the page; none of it says anything of the robot."""


@dataclass(frozen=True, slots=True)
class Where:
    """What is served, and where."""

    host: str
    port: int
    socket: Path | None
    recordings: Path
    work: Path
    robot: Path | None = None
    users: Path | None = None
    certificate: Path | None = None
    key: Path | None = None
    as_built: Path | None = None
    """File with the hidden fault of the simulated robot; its daemon reads it there."""

    @property
    def local(self) -> bool:
        """Whether only this machine can reach it."""
        return self.host in LOCAL


def serve(where: Where) -> None:
    """Serve until SIGINT or SIGTERM. Raises ConfigError where a network could come in unasked."""
    if where.users is None and not where.local:
        raise ConfigError(
            f"--host {where.host}: on a network people sign in; make a file of them with"
            " 'deltactl web user NAME --file users.yaml', and give it with --users"
        )
    if (where.certificate is None) != (where.key is None):
        raise ConfigError("--certificate and --key belong together; give both")
    users = Users(where.users) if where.users is not None else None
    sessions = Sessions(users) if users is not None else None
    door = Door()
    sockets = listen(where.host, where.port, door)
    secure = where.certificate is not None
    logging.basicConfig(level=logging.INFO, format="%(asctime)s %(levelname)s %(message)s")
    logging.getLogger("deltactl.web.access.guard").setLevel(logging.WARNING)
    with _linked(where) as site:
        if users is not None:
            site.tokens = Tokens(where.work / "tokens.json", users)
        app = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)
        if users is not None and sessions is not None:
            add_login(app, users, sessions, secure)
        add_pages(app, site)
        config = uvicorn.Config(
            Guard(FilesOfPages(app), sessions, site.tokens, local_only=where.local),
            http=protocol_of(door),
            loop="asyncio",
            log_level="warning",
            access_log=False,
            server_header=False,
            proxy_headers=False,
            timeout_graceful_shutdown=1,
            ws_max_size=MAX_BODY,
            ssl_certfile=where.certificate,
            ssl_keyfile=where.key,
        )
        logging.getLogger("uvicorn.error").addFilter(not_cut_off)
        # Uvicorn ends in good order and then raises the signal again: what surrounds this
        # call (a simulated daemon) has to be ended too.
        signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
        uvicorn.Server(config).run(sockets)


def not_cut_off(record: logging.LogRecord) -> bool:
    """Leaves out the traceback of a request that the end of the service cuts off.

    Uvicorn says in one line how many there were.
    """
    return not (record.exc_info and isinstance(record.exc_info[1], asyncio.CancelledError))


def add_pages(app: FastAPI, site: Site) -> None:
    """The page and the reports; NiceGUI answers all that no route before has."""

    @app.get("/health")
    def health() -> Response:
        return PlainTextResponse("ok")

    @app.post(UPLOAD)
    async def recording(request: Request) -> Response:
        if not operates():
            return PlainTextResponse(LOOKS, 403)
        try:
            kept = await site.own.take(
                request.query_params.get("name", ""), _while_operating(request)
            )
        except NotReady as error:
            return PlainTextResponse(str(error), 403)
        except DeltactlError as error:
            return PlainTextResponse(str(error), 400)
        return PlainTextResponse(f"{site.own.name_of(kept)} is in the list: press Diagnose")

    @app.get("/made/{key}")
    def made(key: str) -> Response:
        path = site.path_of(key)
        if path is None or not path.is_file():
            return PlainTextResponse("no such report; open it from the list again", 404)
        return FileResponse(path, media_type="text/html", headers=REPORT_HEADERS)

    for name, kind in APP.items():
        app.get(f"/{name}")(_sending(APP_FOLDER / name, kind))
    app.mount(PLACE, make_api(site))
    built = BuiltPages()

    @ui.page("/", title=TITLE)
    def robot(request: Request) -> None:
        session: Session = request.scope["deltactl"]
        built.add(ui.context.client, request.client.host if request.client else "?")
        RobotPage(site, session)

    ui.run_with(
        app,
        title=TITLE,
        reconnect_timeout=RECONNECT_S,
        binding_refresh_interval=None,
        show_welcome_message=False,
        favicon="🦾",
    )
    core.app.config.socket_io_js_transports = ["websocket"]
    core.app.add_exception_handler(404, nothing_here)
    judge_messages()
    put_into_pages(KNOWN)


def _sending(path: Path, kind: str) -> Callable[[], Response]:
    def send() -> Response:
        return FileResponse(path, media_type=kind)

    return send


async def _while_operating(request: Request) -> AsyncIterator[bytes]:
    """What comes, as long as it comes from an operator. Raises NotReady."""
    async for piece in request.stream():
        if not operates():
            raise NotReady(LOOKS)
        yield piece


@contextmanager
def _linked(where: Where) -> Iterator[Site]:
    where.work.mkdir(parents=True, exist_ok=True, mode=0o700)
    os.chmod(where.work, 0o700)
    link = DaemonLink(where.socket)
    link.start()
    try:
        hidden_fault = None if where.as_built is None else HiddenFault(where.as_built)
        yield Site(link, KnownRobots(where.robot), where.recordings, where.work, hidden_fault)
    finally:
        link.close()
