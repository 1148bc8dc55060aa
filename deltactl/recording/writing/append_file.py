"""A file that only grows, by whole pieces: a failed write leaves what stood before."""

from __future__ import annotations

import contextlib
import fcntl
import os
from pathlib import Path

from deltactl.foundation.errors import RecordingError


class AppendFile:
    """A new file, locked while it is written, that is never left with half a piece.

    Raises RecordingError when it exists, cannot be made, or would leave less than
    `reserve_bytes` free on its disk.
    """

    def __init__(self, path: Path, reserve_bytes: int = 0):
        self.path = path
        self.reserve_bytes = reserve_bytes
        self.size = 0
        self._descriptor = _create(path)
        try:
            if (free_bytes := self.free_bytes()) < reserve_bytes:
                raise RecordingError(
                    f"{path}: only {free_bytes // 2**20} MiB free on this disk, "
                    f"{reserve_bytes // 2**20} MiB must stay free; delete old recordings"
                )
            # The lock tells `retention.prune` that this one is being written.
            fcntl.flock(self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BaseException:
            self.discard()
            raise

    def append(self, data: bytes | bytearray | memoryview) -> None:
        """Add `data` wholly or not at all. Raises OSError (disk full, device gone)."""
        rest = memoryview(data)
        try:
            while rest:
                rest = rest[os.write(self._descriptor, rest) :]
        except OSError:
            self.truncate(self.size)
            raise
        self.size += len(data)

    def truncate(self, size: int) -> None:
        """Go back to an earlier size; a disk that refuses even this is left alone."""
        with contextlib.suppress(OSError):
            os.ftruncate(self._descriptor, size)
            os.lseek(self._descriptor, size, os.SEEK_SET)
            self.size = size

    def sync(self) -> None:
        """Have the disk hold everything appended so far. Raises OSError."""
        os.fdatasync(self._descriptor)

    def free_bytes(self) -> int:
        """What the disk has left for an ordinary user."""
        state = os.fstatvfs(self._descriptor)
        return state.f_bavail * state.f_frsize

    def discard(self) -> None:
        """Close and remove the file."""
        self.close()
        self.path.unlink(missing_ok=True)

    def close(self) -> None:
        """Give the file back; safe to call twice."""
        descriptor, self._descriptor = self._descriptor, -1
        if descriptor >= 0:
            with contextlib.suppress(OSError):
                os.close(descriptor)


def _create(path: Path) -> int:
    """Make the file and its folder. O_EXCL: two recorders can never share a name."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RecordingError(f"{path.parent}: cannot be made ({error.strerror})") from error
    try:
        return os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o644)
    except FileExistsError:
        raise RecordingError(
            f"{path}: exists already and is not overwritten; name another file"
        ) from None
    except OSError as error:
        raise RecordingError(f"{path}: cannot be made ({error.strerror})") from error
