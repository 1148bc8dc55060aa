"""Who may sign in, and who is signed in.

A file that only the service reads has names, roles and hashed passwords. Sessions end, and are kept
in memory, so that a restart ends all.
"""

from __future__ import annotations

import hashlib
import hmac
import logging
import os
import secrets
import time
from collections.abc import Callable
from contextvars import ContextVar
from dataclasses import dataclass
from http.cookies import CookieError, SimpleCookie
from pathlib import Path
from typing import Annotated, Literal

import yaml
from pydantic import Field

from deltactl.foundation.errors import ConfigError
from deltactl.foundation.plain_file import write_whole
from deltactl.foundation.strict_yaml import Document, StrictModel

Role = Literal["operator", "viewer"]
SCRYPT = {"n": 2**14, "r": 8, "p": 5}
"""16 MB and some 0.2 s a guess (OWASP Password Storage Cheat Sheet, 2024)."""
SALT_BYTES, KEY_BYTES = 16, 32
TOKEN_BYTES = 24
SHORTEST = 10
_log = logging.getLogger(__name__)


class User(StrictModel):
    """One line of the file."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9_.-]{1,40}$", description="letters, digits")]
    role: Role
    salt: Annotated[str, Field(pattern="^[0-9a-f]{32}$", description="made by deltactl web user")]
    scrypt: Annotated[str, Field(pattern="^[0-9a-f]{64}$", description="made by deltactl web user")]

    def has(self, password: str) -> bool:
        """Whether that is the password."""
        return hmac.compare_digest(_hash(password, bytes.fromhex(self.salt)), self.scrypt)


class UserFile(StrictModel):
    """The whole file."""

    users: Annotated[tuple[User, ...], Field(max_length=100, description="a lab, not a city")] = ()


class Users:
    """The file as it is now: it is looked at for every request, and read again when it changed.

    While it cannot be read nobody signs in, and those who are signed in stay as they were: a
    mistake in the file must not take the stop button from everybody.
    """

    def __init__(self, path: Path):
        """Raises ConfigError for a file that cannot be used."""
        self._path = path
        self._seen = _state_of(path)
        self._by_name = load_users(path)
        self._problem = ""

    @property
    def problem(self) -> str:
        """Why the file cannot be used, in one line; empty when it can."""
        self._look()
        return self._problem

    def get(self, name: str) -> User | None:
        """Somebody by name, as the file says now."""
        self._look()
        return self._by_name.get(name)

    def _look(self) -> None:
        state = _state_of(self._path)
        if state == self._seen:
            return
        self._seen = state
        try:
            self._by_name, self._problem = load_users(self._path), ""
            _log.info("%s has changed, and is in force", self._path)
        except (ConfigError, OSError) as error:
            self._problem = str(error)
            _log.error("nobody can sign in: %s", error)


def _state_of(path: Path) -> tuple[int, ...]:
    """Changes with every way to change a file: written, replaced, or given to others."""
    try:
        its = path.stat()
    except OSError:
        return ()
    return its.st_ino, its.st_mtime_ns, its.st_ctime_ns, its.st_size


def load_users(path: Path) -> dict[str, User]:
    """Everybody who may sign in. Raises ConfigError, also when others could read the file."""
    found = Document.read(path).check(UserFile)
    its = path.stat()
    if its.st_mode & 0o077 or its.st_uid not in (os.getuid(), 0):
        raise ConfigError(f"{path}: others can read it; type: chmod 600 {path}")
    if not found.users:
        raise ConfigError(f"{path}: nobody may sign in; add somebody with 'deltactl web user'")
    return {user.name: user for user in found.users}


def add_user(path: Path, name: str, role: Role, password: str) -> None:
    """Add somebody, or change their password and role. Raises ConfigError."""
    if len(password) < SHORTEST:
        raise ConfigError(f"a password needs {SHORTEST} characters at least")
    salt = secrets.token_bytes(SALT_BYTES)
    entry = {
        "name": name,
        "role": role,
        "salt": salt.hex(),
        "scrypt": _hash(password, salt),
    }
    before = Document.read(path).check(UserFile).users if path.exists() else ()
    kept = [user.model_dump() for user in before if user.name != name]
    text = yaml.safe_dump({"users": [*kept, entry]}, sort_keys=False)
    Document(path, text).check(UserFile)
    write_whole(path, text, mode=0o600)


def new_token() -> str:
    """A password that nobody has to think up."""
    return secrets.token_urlsafe(TOKEN_BYTES)


def right(user: User | None, password: str) -> User | None:
    """The user whose password that is; None when it is wrong or there is none, in the same time."""
    if user is None:
        _hash(password, b"\0" * SALT_BYTES)
        return None
    return user if user.has(password) else None


def _hash(password: str, salt: bytes) -> str:
    raw = password.encode("utf-8", errors="replace")
    return hashlib.scrypt(raw, salt=salt, dklen=KEY_BYTES, maxmem=2**26, **SCRYPT).hex()


COOKIE = "deltactl"
LASTS_S = 8 * 3600.0
MOST = 20
"""Sessions of one user; the oldest goes first: nobody ends the sessions of others by signing in."""


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
"""Session of the request, or of the message of a connection, that is carried out."""


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
        self._open = {word: session for word, session in self._open.items() if self._lasts(session)}
        its = [word for word, session in self._open.items() if session.name == user.name]
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
