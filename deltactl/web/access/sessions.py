"""Who is signed in, and who asks now: sessions that end, kept in memory, so a restart ends all."""

from __future__ import annotations

import secrets
import time
from collections.abc import Callable
from contextvars import ContextVar
from dataclasses import dataclass
from http.cookies import CookieError, SimpleCookie

from deltactl.web.access.users import Role, User, Users

COOKIE = "deltactl"
LASTS_S = 8 * 3600.0
MOST = 20
"""Of one user, whose oldest goes first: nobody ends the sessions of others by signing in."""


@dataclass(frozen=True, slots=True)
class Session:
    """Somebody who signed in, until when (monotonic clock), as the users' file said then."""

    name: str
    role: Role
    until_s: float
    user: User | None = None


NOBODY_ASKED = Session("", "operator", float("inf"))
"""On this machine alone, without passwords."""

ASKS: ContextVar[Callable[[], Session | None]] = ContextVar("asks")
"""Of the request, or the message of a connection, that is being carried out."""


def asking() -> Session | None:
    """Whose cookie the request carries that is being carried out; None when it has ended.

    It is looked up at each call: what began in a session is not continued after it.
    """
    return ASKS.get(_nobody)()


def operates() -> bool:
    """Whether whoever asks now may command the robot."""
    session = asking()
    return session is not None and session.role == "operator"


def _nobody() -> None:
    return None


class Sessions:
    """By secret words in cookies. A session ends when its user's entry in the file changes."""

    def __init__(self, users: Users, lasts_s: float = LASTS_S):
        self._users, self._lasts_s = users, lasts_s
        self._open: dict[str, Session] = {}

    def begin(self, user: User) -> str:
        """A new session; returns the cookie's value."""
        self._open = {word: one for word, one in self._open.items() if self._lasts(one)}
        its = [word for word, one in self._open.items() if one.name == user.name]
        for word in its[: max(0, len(its) + 1 - MOST)]:
            del self._open[word]
        word = secrets.token_urlsafe(32)
        until_s = time.monotonic() + self._lasts_s
        self._open[word] = Session(user.name, user.role, until_s, user)
        return word

    def end(self, word: str) -> None:
        """Sign out."""
        self._open.pop(word, None)

    def of(self, word: str) -> Session | None:
        """Whose it is; None when it has ended."""
        found = self._open.get(word)
        return found if found is not None and self._lasts(found) else None

    def _lasts(self, session: Session) -> bool:
        unchanged = self._users.get(session.name) == session.user
        return session.until_s > time.monotonic() and unchanged


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
