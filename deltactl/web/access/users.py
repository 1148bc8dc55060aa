"""Who may sign in: a file of names, roles and hashed passwords that only the service reads."""

from __future__ import annotations

import hashlib
import hmac
import logging
import os
import secrets
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
    salt: Annotated[str, Field(pattern="^[0-9a-f]{32}$", description="made by deltactl web-user")]
    scrypt: Annotated[str, Field(pattern="^[0-9a-f]{64}$", description="made by deltactl web-user")]

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
        raise ConfigError(f"{path}: nobody may sign in; add somebody with 'deltactl web-user'")
    return {user.name: user for user in found.users}


def add_user(path: Path, name: str, role: Role, password: str) -> None:
    """Add somebody, or change their password and role. Raises ConfigError."""
    if len(password) < SHORTEST:
        raise ConfigError(f"a password needs {SHORTEST} characters at least")
    salt = secrets.token_bytes(SALT_BYTES)
    entry = {
        "name": name, "role": role, "salt": salt.hex(), "scrypt": _hash(password, salt),
    }  # fmt: skip
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
