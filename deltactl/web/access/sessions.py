"""Who is signed in: sessions that end, kept in memory, so that a restart ends them all."""

from __future__ import annotations

import secrets
import time
from dataclasses import dataclass
from http.cookies import CookieError, SimpleCookie

from deltactl.web.access.users import Role

COOKIE = "deltactl"
LASTS_S = 8 * 3600.0
MOST = 200


@dataclass(frozen=True, slots=True)
class Session:
    """Somebody who signed in, until when (monotonic clock)."""

    name: str
    role: Role
    until_s: float


NOBODY_ASKED = Session("", "operator", float("inf"))
"""On this machine alone, without passwords."""


class Sessions:
    """By secret words in cookies."""

    def __init__(self, lasts_s: float = LASTS_S):
        self._lasts_s = lasts_s
        self._open: dict[str, Session] = {}

    def begin(self, name: str, role: Role) -> str:
        """A new session; returns the cookie's value."""
        self._forget_old()
        while len(self._open) >= MOST:
            self._open.pop(next(iter(self._open)))
        word = secrets.token_urlsafe(32)
        self._open[word] = Session(name, role, time.monotonic() + self._lasts_s)
        return word

    def end(self, word: str) -> None:
        """Sign out."""
        self._open.pop(word, None)

    def of(self, word: str) -> Session | None:
        """Whose it is; None when it has ended."""
        found = self._open.get(word)
        return found if found is not None and found.until_s > time.monotonic() else None

    def _forget_old(self) -> None:
        now_s = time.monotonic()
        self._open = {word: one for word, one in self._open.items() if one.until_s > now_s}


def word_in(cookies: str) -> str:
    """The session's word in a Cookie header; empty when there is none."""
    try:
        found = SimpleCookie(cookies).get(COOKIE)
    except CookieError:
        return ""
    return found.value if found is not None else ""


def cookie(word: str, secure: bool) -> str:
    """The Set-Cookie header that hands out a session, or with an empty word takes it back."""
    age = f"Max-Age={LASTS_S:.0f}" if word else "Max-Age=0"
    return f"{COOKIE}={word}; {age}; Path=/; HttpOnly; SameSite=Strict{'; Secure' * secure}"
