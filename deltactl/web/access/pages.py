"""Built pages: whose each is, and how many wait for a browser that does not come.

NiceGUI keeps a page in memory from the request that builds it. What a browser sends later names
the page it means, and NiceGUI asks no further. Here everything that is sent is held against the
session that sends it, at the moment it comes: a page serves the session it was built for.
"""

from __future__ import annotations

import logging
from collections import OrderedDict
from collections.abc import Callable
from typing import Any
from urllib.parse import parse_qs

import socketio
from fastapi import Request
from nicegui import Client, core
from starlette.responses import PlainTextResponse, Response

from deltactl.web.access.door import network_of
from deltactl.web.access.guard import App, Receive, Scope, Send
from deltactl.web.access.users import Session, asking

MOST_UNSEEN, MOST_UNSEEN_EACH = 24, 8
"""Pages that were built and have no browser yet, in all and for one address."""
OF_A_PAGE = "/_nicegui/client/"
"""Before the name of a page, and what is sent to it outside its connection: files."""
RELOAD = "Implicit handshake failed"
"""The words with which NiceGUI's script loads the page anew, for the session it has now."""
_log = logging.getLogger(__name__)


class BuiltPages:
    """All pages of this process. One is enough: NiceGUI has one list of them."""

    def __init__(self) -> None:
        self._unseen: OrderedDict[str, tuple[str, Client]] = OrderedDict()

    def add(self, client: Client, peer: str) -> None:
        """Note a page that is being built; the oldest that nobody came for makes room."""
        network = network_of(peer)
        same = [peer_of for peer_of, _ in self._unseen.values() if peer_of == network]
        if len(same) >= MOST_UNSEEN_EACH:
            self._drop(network)
        elif len(self._unseen) >= MOST_UNSEEN:
            self._drop(None)
        self._unseen[client.id] = (network, client)
        client.on_connect(lambda: self._forget(client.id))
        client.on_delete(lambda: self._forget(client.id))

    def _drop(self, network: str | None) -> None:
        for its, client in list(self._unseen.values()):
            if network in (None, its):
                client.delete()
                return

    def _forget(self, name: str) -> None:
        self._unseen.pop(name, None)


def judge_messages() -> None:
    """Let NiceGUI hear only what comes from the session that a page was built for.

    Also no other origin is answered, and no other way than a WebSocket, of which the guard sees
    every message.
    """
    sio = core.sio
    sio.eio.cors_allowed_origins = []  # no header for anybody; the guard compares origins
    sio.eio.transports = ["websocket"]
    heard = sio.handlers["/"]
    for name in ("event", "javascript_response", "ack", "log"):
        sio.on(name, _judged(heard[name]))
    connect, handshake = heard["connect"], heard["handshake"]

    async def on_connect(sid: str, environ: dict[str, Any], auth: Any = None) -> None:
        asked = parse_qs(environ.get("QUERY_STRING", "")).get("client_id", [""])[0]
        if not may_use(asked):
            raise socketio.exceptions.ConnectionRefusedError(RELOAD)
        await connect(sid, environ, auth)

    async def on_handshake(sid: str, data: Any) -> bool:
        return may_use(_named(data)) and bool(await handshake(sid, data))

    sio.on("connect", on_connect)
    sio.on("handshake", on_handshake)


def may_use(name: str) -> bool:
    """Whether a page, by its name, was built for the session that asks now."""
    client = Client.instances.get(name)
    session = asking()
    return client is not None and session is not None and session is _owner(client)


def _owner(client: Client) -> Session | None:
    owner: Session | None = client.request.scope.get("deltactl")
    return owner


def _judged(handler: Callable[[str, Any], None]) -> Callable[[str, Any], None]:
    def judged(sid: str, message: Any) -> None:
        if may_use(_named(message)):
            handler(sid, message)
        else:
            _log.warning("a message to a page of another session, or an ended one, is left out")

    return judged


def _named(message: Any) -> str:
    return str(message.get("client_id", "")) if isinstance(message, dict) else ""


class FilesOfPages:
    """An ASGI application around another: files that are sent to a page are judged, too."""

    def __init__(self, app: App):
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let a request through, or refuse it in one line."""
        path = scope.get("path", "")
        if path.startswith(OF_A_PAGE):
            name = path.removeprefix(OF_A_PAGE).split("/")[0]
            if not may_use(name):
                refusal = PlainTextResponse("that page is not yours; reload it", 403)
                await refusal(scope, receive, send)
                return
        await self._app(scope, receive, send)


def nothing_here(request: Request, _: Exception) -> Response:
    """The answer to an address that there is not: NiceGUI would build a page to say so."""
    return PlainTextResponse(f"there is nothing at {request.url.path[:100]!r}\n", 404)
