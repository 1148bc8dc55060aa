"""The page to sign in, plain HTML without a line of script, and what slows down guessing."""

from __future__ import annotations

import html
import logging
from asyncio import Semaphore
from collections import OrderedDict

from fastapi import FastAPI, Request
from starlette.concurrency import run_in_threadpool
from starlette.responses import HTMLResponse, RedirectResponse, Response

from deltactl.firmware_py.daemon.limits import Allowance
from deltactl.web.access.door import network_of
from deltactl.web.access.policy import NONCE
from deltactl.web.access.users import Sessions, Users, cookie, right, word_in

ADDRESS_HZ, ADDRESS_BURST = 0.1, 12
"""Wrong tries from one address: six a minute."""
USER_HZ, USER_BURST = 0.05, 6
"""Tries for one user among those: three a minute."""
MOST_KNOWN = 2000
"""Pairs and addresses that are remembered, the newest."""
AT_ONCE = 2
"""Passwords that are compared at a time: whoever guesses does not take the robot's processor."""
LONGEST = 200
_log = logging.getLogger(__name__)


class Tries:
    """How often somebody may still be wrong, by address, and by user and address.

    Nothing is counted for a user alone: whoever guesses a password elsewhere would keep its owner
    out. A try that was right costs nothing.
    """

    def __init__(self) -> None:
        self._left: OrderedDict[tuple[str, str], Allowance] = OrderedDict()

    def take(self, user: str, peer: str) -> bool:
        """Count a try; False when there is none left."""
        network = network_of(peer)
        # Both are counted, so that many names cost an address no less than one.
        mine = self._of(user, network, USER_HZ, USER_BURST).take()
        return self._of("", network, ADDRESS_HZ, ADDRESS_BURST).take() and mine

    def was_right(self, user: str, peer: str) -> None:
        """Give the try back. The address keeps what others have tried from it."""
        network = network_of(peer)
        self._left.pop((user, network), None)
        self._of("", network, ADDRESS_HZ, ADDRESS_BURST).give_back()

    def _of(self, user: str, network: str, rate_hz: float, burst: int) -> Allowance:
        key = (user, network)
        found = self._left.pop(key, None) or Allowance(rate_hz, burst)
        self._left[key] = found
        while len(self._left) > MOST_KNOWN:
            self._left.popitem(last=False)
        return found


def add_login(app: FastAPI, users: Users, sessions: Sessions, secure: bool) -> None:
    """Routes to sign in and out."""
    tries, comparing = Tries(), Semaphore(AT_ONCE)

    @app.get("/login")
    def form(request: Request) -> Response:
        return HTMLResponse(_form(request, ""))

    @app.post("/login")
    async def sign_in(request: Request) -> Response:
        fields = await request.form(max_files=0, max_fields=4)
        name, password = (str(fields.get(key, ""))[:LONGEST] for key in ("name", "password"))
        peer = request.client.host if request.client else "?"
        if users.problem:
            return HTMLResponse(
                _form(request, "Nobody can sign in: see the log of this service."), 503
            )
        if not tries.take(name, peer):
            return HTMLResponse(_form(request, "Too many tries. Wait a minute."), 429)
        async with comparing:
            user = await run_in_threadpool(right, users.get(name), password)
        if user is None:
            _log.warning("%s: wrong name or password for %r", peer, name[:40])
            return HTMLResponse(_form(request, "That name or password is wrong."), 401)
        tries.was_right(name, peer)
        _log.info("%s signed in from %s as %s", user.name, peer, user.role)
        answer = RedirectResponse("/", 303)
        answer.headers["set-cookie"] = cookie(sessions.begin(user), secure)
        return answer

    @app.post("/logout")
    def sign_out(request: Request) -> Response:
        sessions.end(word_in(request.headers.get("cookie", "")))
        answer = RedirectResponse("/login", 303)
        answer.headers["set-cookie"] = cookie("", secure)
        return answer


def _form(request: Request, problem: str) -> str:
    said = f'<p role="alert">{html.escape(problem)}</p>' if problem else ""
    return f"""<!doctype html><html lang="en"><head><meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1"><title>deltactl</title>
<style nonce="{request.scope.get(NONCE, "")}">
body{{font:16px system-ui;display:grid;place-items:center;min-height:90vh;margin:0;
background:#f1f5f9}}form{{background:#fff;padding:2rem;border-radius:8px;display:grid;gap:.8rem;
width:min(20rem,80vw)}}input,button{{font:inherit;padding:.6rem;width:100%;box-sizing:border-box}}
button{{background:#1d4ed8;color:#fff;border:0;border-radius:4px}}p{{color:#b91c1c;margin:0}}</style>
</head><body><form method="post" action="/login"><b>deltactl</b>{said}
<label>Name<input name="name" autocomplete="username" required autofocus></label>
<label>Password or token<input name="password" type="password" autocomplete="current-password"
required></label><button>Sign in</button></form></body></html>"""
