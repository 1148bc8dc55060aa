"""Stands before every request: from where it comes, how often, how large, and from whom."""

from __future__ import annotations

import asyncio
import logging
from collections import Counter, OrderedDict
from collections.abc import Awaitable, Callable, MutableMapping
from dataclasses import dataclass, field
from typing import Any, Final
from urllib.parse import urlsplit

from deltactl.firmware_py.daemon.limits import Allowance
from deltactl.web.access.door import network_of
from deltactl.web.access.policy import new_nonce, policy
from deltactl.web.access.tokens import Tokens
from deltactl.web.access.users import ASKS, NOBODY_ASKED, Session, Sessions, word_in

Scope = MutableMapping[str, Any]
Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

MAX_BODY: Final = 128 * 1024
UPLOAD: Final = "/recording"
"""Takes recordings, which are long; who serves it counts what comes."""
MAX_UPLOAD: Final = 64 * 1024 * 1024
MAX_HEARD: Final = 16 * 1024 * 1024
"""Part of a body that is too long that is read before the connection is closed."""
BODY_S: Final = 20.0
"""For a whole body; a recording's own pieces are timed where they are kept."""
ANSWER_S: Final = 60.0
"""For a browser to take one piece of an answer."""
MAX_PAGES, MAX_PAGES_EACH = 40, 30
"""Connected at a time, in all and from one address of a network."""
PAGE: Final = "/"
CONNECTIONS: Final = "/_nicegui_ws"
"""What socket.io answers; only as a WebSocket, whose every message is judged."""
BUILD_HZ, BUILD_BURST = 1.0, 30
"""Pages that are built for one address: each costs memory and some 0.1 s."""
PEERS_KNOWN: Final = 1000
REQUESTS_HZ, REQUESTS_BURST = 60.0, 600
"""A page is some 80 files; several may be opened at once from behind one address."""
MESSAGES_HZ, MESSAGES_BURST = 60.0, 300
PROGRAMS: Final = "/api/"
"""Where a token counts; the page itself is for sessions with a cookie."""
OPEN: Final = frozenset(
    {"/login", "/health", "/manifest.webmanifest", "/icon-192.png", "/icon-512.png"}
)
LOCAL: Final = frozenset({"127.0.0.1", "localhost", "::1"})
HEADERS: Final = (
    (b"x-content-type-options", b"nosniff"),
    (b"x-frame-options", b"DENY"),
    (b"referrer-policy", b"same-origin"),
    (b"cross-origin-opener-policy", b"same-origin"),
    (b"cross-origin-resource-policy", b"same-origin"),
)

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Refusal:
    """Why not, in one line."""

    status: int
    why: str
    to_login: bool = False


TOO_SLOW: Final = Refusal(408, f"not all of it came within {BODY_S:g} s; send it again")
TOO_LONG: Final = Refusal(413, f"more than {MAX_BODY // 1024} kB are not taken")


@dataclass
class Guard:
    """An ASGI application around another. `sessions` is None where nobody signs in."""

    app: App
    sessions: Sessions | None = None
    tokens: Tokens | None = None
    """The token of a program, which has no cookie."""
    local_only: bool = True
    """Names other than those of this machine are refused (DNS rebinding)."""
    max_pages: int = MAX_PAGES
    _pages: Counter[str] = field(default_factory=Counter)
    _peers: OrderedDict[tuple[str, bool], Allowance] = field(default_factory=OrderedDict)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let a request through, or refuse it in one line."""
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        headers = {
            name.decode("latin-1"): value.decode("latin-1") for name, value in scope["headers"]
        }
        path = scope["path"]
        session = self._session(headers, path)
        refusal = self._refusal(scope, headers, session)
        heard = receive
        whole = scope["path"] != UPLOAD and scope.get("method") not in ("GET", "HEAD")
        if refusal is None and scope["type"] == "http" and whole:
            body = await _body(receive)
            heard = _again(body or b"", receive)
            refusal = TOO_SLOW if body is None else TOO_LONG if len(body) > MAX_BODY else None
        elif refusal is TOO_LONG:
            await _body(receive)
        if refusal is not None:
            _log.info("%s %s refused: %s", _peer(scope), scope["path"], refusal.why)
            await _refuse(scope, refusal, send)
            return
        scope["deltactl"] = session
        ASKS.set(lambda: self._session(headers, path))
        if scope["type"] == "http":
            await self.app(scope, heard, _with_headers(send, policy(new_nonce(scope))))
            return
        peer = _peer(scope)
        self._pages[peer] += 1
        try:
            watched = _Watched(receive, send, lambda: self._session(headers, path) is not None)
            await self.app(scope, watched.receive, watched.send)
        finally:
            self._pages[peer] -= 1
            self._pages += Counter()  # keeps only what is above zero

    def _session(self, headers: dict[str, str], path: str) -> Session | None:
        if self.sessions is None:
            return NOBODY_ASKED
        if self.tokens is not None and "authorization" in headers and path.startswith(PROGRAMS):
            return self.tokens.session(headers["authorization"])
        return self.sessions.of(word_in(headers.get("cookie", "")))

    def _refusal(
        self, scope: Scope, headers: dict[str, str], session: Session | None
    ) -> Refusal | None:
        host, path, peer = headers.get("host", ""), scope["path"], _peer(scope)
        if self.local_only and _name(host) not in LOCAL:
            return Refusal(403, f"this page is not called {_name(host)[:60]!r}; use 127.0.0.1")
        talks = scope["type"] == "websocket" or path.startswith(CONNECTIONS)
        if (astray := _astray(scope, headers, talks)) is not None:
            return astray
        if not self._allowance(peer, False).take():
            return Refusal(429, "too many requests; wait a moment")
        if _length(headers) > (MAX_UPLOAD if path == UPLOAD else MAX_BODY):
            return TOO_LONG
        if session is None and path not in OPEN:
            return Refusal(401, "sign in first", to_login=path == PAGE)
        return self._place(peer, path == PAGE) if talks or path == PAGE else None

    def _place(self, peer: str, builds: bool) -> Refusal | None:
        """Why there is none for one more page; None where there is."""
        if self._pages.total() >= self.max_pages:
            return Refusal(503, f"{self.max_pages} pages are open already; close some and reload")
        if self._pages[peer] >= MAX_PAGES_EACH and peer not in LOCAL:
            return Refusal(
                503, f"{MAX_PAGES_EACH} pages are open from {peer} already; close some and reload"
            )
        if builds and not self._allowance(peer, True).take():
            return Refusal(429, "too many pages at once; wait a moment and reload")
        return None

    def _allowance(self, peer: str, builds: bool) -> Allowance:
        """What one computer may still ask for: pages to be built, or anything."""
        key = (network_of(peer), builds)
        rate_hz, burst = (BUILD_HZ, BUILD_BURST) if builds else (REQUESTS_HZ, REQUESTS_BURST)
        found = self._peers.pop(key, None) or Allowance(rate_hz, burst)
        self._peers[key] = found
        while len(self._peers) > PEERS_KNOWN:
            self._peers.popitem(last=False)
        return found


class _Watched:
    """A connection that ends with its session, and when it says too much."""

    def __init__(self, receive: Receive, send: Send, still_in: Callable[[], bool]):
        self._receive, self._send, self._still_in = receive, send, still_in
        self._allowance = Allowance(MESSAGES_HZ, MESSAGES_BURST)
        self._ended = False

    async def receive(self) -> Message:
        message = await self._receive()
        said = message["type"] == "websocket.receive"
        if said and not (self._still_in() and self._allowance.take()):
            why = "slower, please" if self._still_in() else "signed out"
            await self.send({"type": "websocket.close", "code": 1008, "reason": why})
            self._ended = True
            return {"type": "websocket.disconnect", "code": 1008}
        return message

    async def send(self, message: Message) -> None:
        if not self._ended:
            await self._send(message)


def _astray(scope: Scope, headers: dict[str, str], talks: bool) -> Refusal | None:
    """Refuses what no browser at this page sends; talks: over the connection of a page."""
    if (talks or scope["method"] not in ("GET", "HEAD")) and not _same_origin(headers):
        return Refusal(403, "that came from another site's page, and is not carried out")
    if talks and scope["type"] != "websocket":
        return Refusal(400, "this page needs WebSockets; let the proxy before it pass them")
    if scope["path"] == PAGE and not talks and not _navigates(headers):
        return Refusal(403, "a page is built for a browser that goes to it, for nothing else")
    return None


def _same_origin(headers: dict[str, str]) -> bool:
    """Browsers say where a request comes from; what says nothing is no browser."""
    origin, host = headers.get("origin"), headers.get("host", "")
    if headers.get("sec-fetch-site", "same-origin") not in ("same-origin", "none"):
        return False
    return origin is None or urlsplit(origin).netloc.lower() == host.lower()


def _navigates(headers: dict[str, str]) -> bool:
    """Whether a browser goes to the page, as far as it says: no picture, frame or prefetch."""
    mode = headers.get("sec-fetch-mode", "navigate")
    place = headers.get("sec-fetch-dest", "document")
    early = headers.get("sec-purpose", "") + headers.get("purpose", "")
    return mode == "navigate" and place == "document" and "prefetch" not in early.lower()


def _name(host: str) -> str:
    """The name in a Host header, without its port."""
    return (urlsplit(f"//{host}").hostname or "") if host else ""


def _length(headers: dict[str, str]) -> int:
    text = headers.get("content-length", "0")
    return int(text) if text.isascii() and text.isdigit() and len(text) < 16 else MAX_BODY + 1


def _peer(scope: Scope) -> str:
    client = scope.get("client")
    return str(client[0]) if client else "?"


async def _body(receive: Receive) -> bytes | None:
    """What a request carries; None where it takes too long.

    Of a longer one comes a little more than may be, and the rest stays unread. A browser that is
    still sending hears no answer, so up to `MAX_HEARD` is listened to.
    """
    body, heard = b"", 0
    try:
        async with asyncio.timeout(BODY_S):
            while heard <= MAX_HEARD:
                message = await receive()
                part = message.get("body", b"")
                heard += len(part)
                body += part[: MAX_BODY + 1 - len(body)]
                if message["type"] != "http.request" or not message.get("more_body", False):
                    break
    except TimeoutError:
        return None
    return body


def _again(body: bytes, receive: Receive) -> Receive:
    """Gives a body that has been read, and then what comes."""
    given = False

    async def again() -> Message:
        nonlocal given
        if given:
            return await receive()
        given = True
        return {"type": "http.request", "body": body, "more_body": False}

    return again


def _with_headers(send: Send, rules: bytes) -> Send:
    async def more(message: Message) -> None:
        if message["type"] == "http.response.start":
            own = {name for name, _ in message["headers"]}
            added = [pair for pair in HEADERS if pair[0] not in own]
            if b"content-security-policy" not in own:
                added.append((b"content-security-policy", rules))
            message = {**message, "headers": [*message["headers"], *added]}
        async with asyncio.timeout(ANSWER_S):
            await send(message)

    return more


async def _refuse(scope: Scope, refusal: Refusal, send: Send) -> None:
    if scope["type"] == "websocket":
        await send({"type": "websocket.close", "code": 1008, "reason": refusal.why})
        return
    status, more = refusal.status, []
    if refusal.to_login:
        status, more = 303, [(b"location", b"/login")]
    head = [(b"content-type", b"text/plain; charset=utf-8"), *more]
    await send({"type": "http.response.start", "status": status, "headers": head})
    await send({"type": "http.response.body", "body": f"{refusal.why}\n".encode()})
