"""Serves the page: NiceGUI in a FastAPI application under uvicorn."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import uvicorn
from fastapi import FastAPI
from nicegui import ui
from starlette.responses import FileResponse, PlainTextResponse, Response

from web.belief import Beliefs
from web.link import DaemonLink
from web.page import RobotPage
from web.site import Site

TITLE = "deltactl"
RECONNECT_S = 8.0
REPORT_HEADERS = {"Content-Security-Policy": "sandbox allow-scripts allow-downloads"}
"""A report runs its own charts, and is nobody to the page that shows it."""


@dataclass(frozen=True, slots=True)
class Where:
    """What is served, and where."""

    host: str
    port: int
    socket: Path | None
    recordings: Path
    work: Path
    robot: Path | None = None


def serve(where: Where) -> None:
    """Serve until SIGINT or SIGTERM."""
    with _linked(where) as site:
        app = application(site)
        config = uvicorn.Config(
            app, host=where.host, port=where.port, log_level="warning",
            server_header=False, proxy_headers=False, timeout_graceful_shutdown=1,
        )  # fmt: skip
        uvicorn.Server(config).run()


def application(site: Site) -> FastAPI:
    """The pages and the reports."""
    app = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)

    @app.get("/health")
    def health() -> Response:
        return PlainTextResponse("ok")

    @app.get("/made/{key}")
    def made(key: str) -> Response:
        path = site.path_of(key)
        if path is None or not path.is_file():
            return PlainTextResponse("no such report; open it from the list again", 404)
        return FileResponse(path, media_type="text/html", headers=REPORT_HEADERS)

    @ui.page("/", title=TITLE)
    def robot() -> None:
        RobotPage(site, "operator")

    ui.run_with(
        app, title=TITLE, reconnect_timeout=RECONNECT_S, binding_refresh_interval=None,
        show_welcome_message=False, favicon="🦾",
    )  # fmt: skip
    return app


@contextmanager
def _linked(where: Where) -> Iterator[Site]:
    where.work.mkdir(parents=True, exist_ok=True, mode=0o700)
    os.chmod(where.work, 0o700)
    link = DaemonLink(where.socket)
    link.start()
    try:
        yield Site(link, Beliefs(where.robot), where.recordings, where.work)
    finally:
        link.close()
