"""The listening socket: who may connect, one daemon only, nothing left behind."""

from __future__ import annotations

import contextlib
import fcntl
import io
import os
import socket
import stat
from collections.abc import Iterator
from pathlib import Path

from deltactl.foundation.errors import ServiceError

MOST_PATH_BYTES = 107
"""sun_path of unix(7), less its end."""
MODE = 0o660
"""The file's permissions are the access control: owner and group of the service."""


class Listener:
    """A bound, listening Unix socket. Raises ServiceError when another daemon has it."""

    def __init__(self, path: Path, backlog: int = 128):
        self.path = path
        _check_path(path)
        self._lock = _lock_beside(path)
        try:
            self.socket = _bound(path)
            # Nobody can connect between bind and listen, so nobody slips in before chmod.
            os.chmod(path, MODE)
            found = path.stat()
            self._inode = found.st_ino
            self.owner, self.group = found.st_uid, found.st_gid
            self.socket.listen(backlog)
            self._reserve = _reserve()
        except BaseException:
            self._lock.close()
            raise

    def accept(self) -> socket.socket:
        """The next client. Raises OSError: BlockingIOError for none, EMFILE for want of files."""
        return self.socket.accept()[0]

    @contextlib.contextmanager
    def in_reserve(self) -> Iterator[socket.socket]:
        """The next client on the descriptor that is kept for when none is left; closed at the end.

        Raises OSError when even that is gone.
        """
        if self._reserve >= 0:
            os.close(self._reserve)
            self._reserve = -1
        try:
            with self.accept() as client:
                yield client
        finally:
            with contextlib.suppress(OSError):
                self._reserve = _reserve()

    def wake(self) -> None:
        """Make whoever waits for clients look up; nobody is let in any more."""
        with contextlib.suppress(OSError):
            self.socket.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        """Stop listening, and take the socket file away if it is still ours. Twice is harmless."""
        if self._lock.closed:
            return
        self.socket.close()
        if self._reserve >= 0:
            os.close(self._reserve)
        with contextlib.suppress(OSError):
            if self.path.stat().st_ino == self._inode:
                self.path.unlink()
        self._lock.close()


def _reserve() -> int:
    """A descriptor of nothing, to give up where one is needed and none is left."""
    return os.open(os.devnull, os.O_RDONLY | os.O_CLOEXEC)


def _check_path(path: Path) -> None:
    if len(os.fsencode(path)) > MOST_PATH_BYTES:
        raise ServiceError(
            f"{path}: a socket's path may have {MOST_PATH_BYTES} bytes; choose a shorter"
        )
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        folder = path.parent.stat()
    except OSError as error:
        raise ServiceError(
            f"{path.parent}: cannot be made ({error.strerror}); choose another with --socket"
        ) from error
    open_to_all = folder.st_mode & stat.S_IWOTH and not folder.st_mode & stat.S_ISVTX
    if open_to_all or folder.st_uid not in (os.getuid(), 0):
        raise ServiceError(
            f"{path.parent}: others may replace the socket there; choose a folder of your own"
            " with --socket"
        )


def _lock_beside(path: Path) -> io.FileIO:
    """Hold a lock for as long as we live, so that two daemons cannot start at once."""
    beside = path.with_name(f".{path.name}.lock")
    try:
        flags = os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW
        lock = io.FileIO(os.open(beside, flags, 0o600), "r+")
    except OSError as error:
        raise ServiceError(
            f"{beside}: cannot be opened ({error.strerror}); choose another place with --socket"
        ) from error
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        lock.close()
        raise _taken(path) from error
    return lock


def _bound(path: Path) -> socket.socket:
    """Bind; a file that a dead daemon left is replaced, one that answers or is no socket is not."""
    if path.is_symlink() or path.exists():
        if not path.is_socket() or path.is_symlink():
            raise ServiceError(f"{path}: is no socket; remove it, or choose another with --socket")
        with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as probe:
            probe.settimeout(1.0)
            try:
                probe.connect(str(path))
            except ConnectionRefusedError:
                path.unlink(missing_ok=True)
            except OSError as error:
                raise _taken(path) from error
            else:
                raise _taken(path)
    bound = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        bound.bind(str(path))
    except OSError as error:
        bound.close()
        raise ServiceError(f"{path}: cannot be opened ({error.strerror})") from error
    return bound


def _taken(path: Path) -> ServiceError:
    return ServiceError(
        f"another daemon answers at {path}; stop it first ('systemctl stop deltactl'),"
        " or choose another place with --socket"
    )
