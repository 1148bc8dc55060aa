"""Where the socket is, and who is at its other end."""

from __future__ import annotations

import os
import socket
import struct
from dataclasses import dataclass
from pathlib import Path

SERVICE_FOLDER = Path("/run/deltactl")
"""RuntimeDirectory of systemd/deltactl.service."""
NAME = "deltactl.sock"
_SO_PEERGROUPS = 59
"""asm-generic/socket.h, since Linux 4.13: the other groups of the peer, 32 bits each."""
_MOST_GROUPS = 1024
_UCRED = struct.Struct("3I")
"""struct ucred of unix(7): pid, uid, gid."""


def daemon_socket(given: Path | None = None) -> Path:
    """Where a daemon listens: as given, in the unit's runtime directory, or in the developer's."""
    if given is not None:
        return given
    folder = os.environ.get("RUNTIME_DIRECTORY", "").split(":")[0]
    return Path(folder) / NAME if folder else own_folder() / NAME


def client_sockets(given: Path | None = None) -> tuple[Path, ...]:
    """Where a client looks, in order: as given, DELTACTL_SOCKET, own daemon, the service."""
    if given is None and (named := os.environ.get("DELTACTL_SOCKET")):
        given = Path(named)
    if given is not None:
        return (given,)
    service = SERVICE_FOLDER / NAME
    own = own_folder()
    return (own / NAME, service) if is_private(own) else (service,)


def own_folder() -> Path:
    """Private folder of a user who runs a daemon by hand."""
    runtime = os.environ.get("XDG_RUNTIME_DIR")
    return Path(runtime) if runtime else Path(f"/tmp/deltactl-{os.getuid()}")


def is_private(folder: Path) -> bool:
    """Whether the folder exists and is ours alone; in /tmp anybody may have made it."""
    try:
        found = folder.lstat()
    except OSError:
        return False
    return found.st_uid == os.getuid() and not found.st_mode & 0o022 and folder.is_dir()


@dataclass(frozen=True, slots=True)
class Peer:
    """The process at the other end, as the kernel knows it (SO_PEERCRED)."""

    pid: int
    uid: int
    groups: frozenset[int] = frozenset()

    @classmethod
    def of(cls, connection: socket.socket) -> Peer:
        """Ask the kernel; it noted the ids when the peer connected."""
        raw = connection.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _UCRED.size)
        pid, uid, gid = _UCRED.unpack(raw)
        return cls(pid, uid, frozenset({gid, *_more_groups(connection)}))

    def may_use(self, owner: int, group: int) -> bool:
        """Whether it is root, the owner of the socket, or in its group.

        The kernel has asked the file's mode already; this holds when somebody changes that.
        """
        return self.uid in (0, owner) or group in self.groups

    def __str__(self) -> str:
        return f"uid {self.uid} (process {self.pid})"


def _more_groups(connection: socket.socket) -> tuple[int, ...]:
    """Supplementary groups; none where the kernel does not tell, which lets nobody in."""
    try:
        raw = connection.getsockopt(socket.SOL_SOCKET, _SO_PEERGROUPS, 4 * _MOST_GROUPS)
    except OSError:
        return ()
    return struct.unpack(f"{len(raw) // 4}I", raw)
