"""The page to sign in, plain HTML without a line of script."""

from __future__ import annotations

import html
import logging

from fastapi import FastAPI, Request
from starlette.concurrency import run_in_threadpool
from starlette.responses import HTMLResponse, RedirectResponse, Response

from deltactl.firmware_py.daemon.limits import Allowance
from deltactl.web.access.sessions import Sessions, cookie, word_in
from deltactl.web.access.users import User, right

TRIES_HZ, TRIES_BURST = 0.1, 8
"""Of everybody together: six a minute. Whoever guesses does not take the robot's processor."""
LONGEST = 200
_log = logging.getLogger(__name__)


def add_login(app: FastAPI, users: dict[str, User], sessions: Sessions, secure: bool) -> None:
    """Routes to sign in and out."""
    tries = Allowance(TRIES_HZ, TRIES_BURST)

    @app.get("/login")
    def form() -> Response:
        return HTMLResponse(_form(""))

    @app.post("/login")
    async def sign_in(request: Request) -> Response:
        if not tries.take():
            return HTMLResponse(_form("Too many tries. Wait a minute."), 429)
        fields = await request.form(max_files=0, max_fields=4)
        name, password = (str(fields.get(key, ""))[:LONGEST] for key in ("name", "password"))
        user = await run_in_threadpool(right, users, name, password)
        peer = request.client.host if request.client else "?"
        if user is None:
            _log.warning("%s: wrong name or password for %r", peer, name[:40])
            return HTMLResponse(_form("That name or password is wrong."), 401)
        _log.info("%s signed in from %s as %s", user.name, peer, user.role)
        answer = RedirectResponse("/", 303)
        answer.headers["set-cookie"] = cookie(sessions.begin(user.name, user.role), secure)
        return answer

    @app.post("/logout")
    def sign_out(request: Request) -> Response:
        sessions.end(word_in(request.headers.get("cookie", "")))
        answer = RedirectResponse("/login", 303)
        answer.headers["set-cookie"] = cookie("", secure)
        return answer


def _form(problem: str) -> str:
    said = f'<p role="alert">{html.escape(problem)}</p>' if problem else ""
    return f"""<!doctype html><html lang="en"><head><meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1"><title>deltactl</title>
<style>body{{font:16px system-ui;display:grid;place-items:center;min-height:90vh;margin:0;
background:#f1f5f9}}form{{background:#fff;padding:2rem;border-radius:8px;display:grid;gap:.8rem;
width:min(20rem,80vw)}}input,button{{font:inherit;padding:.6rem;width:100%;box-sizing:border-box}}
button{{background:#1d4ed8;color:#fff;border:0;border-radius:4px}}p{{color:#b91c1c;margin:0}}</style>
</head><body><form method="post" action="/login"><b>deltactl</b>{said}
<label>Name<input name="name" autocomplete="username" required autofocus></label>
<label>Password or token<input name="password" type="password" autocomplete="current-password"
required></label><button>Sign in</button></form></body></html>"""
