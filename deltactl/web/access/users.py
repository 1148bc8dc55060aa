"""Who may sign in: a file of names, roles and hashed passwords that only the service reads."""

from __future__ import annotations

import hashlib
import hmac
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


def right(users: dict[str, User], name: str, password: str) -> User | None:
    """Who that is; None when the name or the password is wrong, in the same time."""
    user = users.get(name)
    if user is None:
        _hash(password, b"\0" * SALT_BYTES)
        return None
    return user if user.has(password) else None


def _hash(password: str, salt: bytes) -> str:
    raw = password.encode("utf-8", errors="replace")
    return hashlib.scrypt(raw, salt=salt, dklen=KEY_BYTES, maxmem=2**26, **SCRYPT).hex()
