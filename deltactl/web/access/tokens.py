"""Tokens for programs: each belongs to a user of the file, is shown once, and can be taken back.

A token has 192 random bits, so that a plain hash of it is enough, which costs nothing a request.
It does no more than its user may, and ends when the user's entry in the file changes.
"""

from __future__ import annotations

import hashlib
import json
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Final

from deltactl.foundation.errors import ConfigError
from deltactl.foundation.plain_file import write_whole
from deltactl.web.access.users import Role, Session, Users, new_token

MOST_EACH: Final = 10
BEARER: Final = "bearer "


@dataclass(frozen=True, slots=True)
class Token:
    """What is kept of one: whose it is, what for, what it may, and its hash."""

    user: str
    salt: str
    """The mark of the user's entry; a new password changes it."""
    label: str
    role: Role
    sha256: str


class Tokens:
    """A file of the page's own, which nobody else can read."""

    def __init__(self, path: Path, users: Users):
        self._path, self._users = path, users
        self._by_hash: dict[str, Token] = {}
        self._sessions: dict[str, Session] = {}
        with suppress(OSError, ValueError, TypeError):
            kept = [Token(**one) for one in json.loads(path.read_text(encoding="utf-8"))]
            self._by_hash = {token.sha256: token for token in kept}

    def make(self, user: str, label: str, looks_only: bool) -> str:
        """A new token, which is nowhere else from now on. Raises ConfigError."""
        owner = self._users.get(user)
        if owner is None:
            raise ConfigError("a token belongs to somebody who signs in; start with --users FILE")
        if len(self.of(user)) >= MOST_EACH:
            raise ConfigError(f"you have {MOST_EACH} tokens already; take one back first")
        word = new_token()
        role: Role = "viewer" if looks_only else owner.role
        token = Token(user, owner.salt, label[:40] or "program", role, _hash(word))
        self._by_hash[token.sha256] = token
        self._keep()
        return word

    def of(self, user: str) -> list[Token]:
        """Those of a user that are in force."""
        return [token for token in self._by_hash.values() if token.user == user and self._ok(token)]

    def take_back(self, user: str, sha256: str) -> None:
        """End one; nothing where it is none of that user's."""
        token = self._by_hash.get(sha256)
        if token is not None and token.user == user:
            del self._by_hash[sha256]
            self._sessions.pop(sha256, None)
            self._keep()

    def session(self, authorization: str) -> Session | None:
        """Whose request that is, by its Authorization header; None where it is nobody's."""
        if not authorization.lower().startswith(BEARER):
            return None
        token = self._by_hash.get(_hash(authorization[len(BEARER) :].strip()))
        if token is None or not self._ok(token):
            return None
        owner = self._users.get(token.user)
        role: Role = "viewer" if owner is None or owner.role == "viewer" else token.role
        before = self._sessions.get(token.sha256)
        if before is None or before.role != role:
            before = Session(token.user, role, float("inf"), owner)
            self._sessions[token.sha256] = before
        return before

    def _ok(self, token: Token) -> bool:
        owner = self._users.get(token.user)
        return owner is not None and owner.salt == token.salt

    def _keep(self) -> None:
        kept = [asdict(token) for token in self._by_hash.values() if self._ok(token)]
        write_whole(self._path, json.dumps(kept), mode=0o600)


def _hash(word: str) -> str:
    return hashlib.sha256(word.encode("utf-8", errors="replace")).hexdigest()
