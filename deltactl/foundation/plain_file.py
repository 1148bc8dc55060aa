"""Whole files: read within bounds, and written beside their place and renamed.

A pipe, a device or a disk image that is read holds nobody up. A file that is there stays until
the new one is whole. Every file that the program writes comes from here, apart from those that
grow while a run goes on: `tests/foundation/test_ways_of_writing.py` names them, and why.
"""

from __future__ import annotations

import contextlib
import errno
import os
import secrets
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from deltactl.foundation.errors import MissingFile, RecordingError

PART = ".part"
"""The ending of a file that is not whole yet; its name begins with a dot."""
_STREAMS = ("/dev/", "/proc/")
"""Folders of names for what is open already: a pipe or a terminal, as /dev/stdout."""
_NEW = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC | os.O_NOFOLLOW


def write_whole(
    path: Path,
    content: str | bytes,
    *,
    fresh: bool = False,
    follow: bool = True,
    mode: int | None = None,
) -> None:
    """Put a text (as UTF-8) or bytes into a file; `whole_file` says how, and what is raised."""
    data = content.encode("utf-8") if isinstance(content, str) else content
    with whole_file(path, fresh=fresh, follow=follow, mode=mode) as out:
        out.write(data)


def check_place(path: Path) -> None:
    """Before long work: raise OSError, as `whole_file`, where no file could be put."""
    try:
        target = os.path.realpath(path)
        if not _is_stream(path, _replaceable(target, follow=True)):
            os.close(_made(part := _part_beside(target), 0o600))
            os.unlink(part)
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from error


@contextmanager
def whole_file(
    path: Path, *, fresh: bool = False, follow: bool = True, mode: int | None = None
) -> Iterator[BinaryIO]:
    """A file to write into, which takes its place when the block ends without an exception.

    Otherwise the file that was there is unchanged, and nothing is left beside it. A file that is
    replaced gives its permissions and, where that is allowed, its owner to the new one. A pipe, a
    terminal or a device is written to as it is.

    fresh: a file that is there is not replaced; FileExistsError.
    follow: a symbolic link stays, and the file that it leads to is replaced; otherwise the link
    itself is. mode: the permissions in place of those of the old file, or of the umask.

    Raises OSError, whose `strerror` is the reason and whose `filename` is `path`.
    """
    try:
        with _written(path, fresh, follow, mode) as out:
            yield out
    except OSError as error:
        ours = error.filename is None or str(error.filename).endswith(PART)
        if error.errno is None or not ours:
            raise
        raise OSError(error.errno, error.strerror, str(path)) from error


@contextmanager
def said_of_output(out: Path, *, fresh: bool = False) -> Iterator[None]:
    """What goes wrong within, while `out` is written, as one line.

    fresh: as for `whole_file`; without it, that something is there is a reason as others. Raises
    RecordingError.
    """
    try:
        yield
    except OSError as error:
        if fresh and isinstance(error, FileExistsError):
            raise _there(out) from None
        reason = error.strerror or error
        raise RecordingError(f"{out}: cannot be written ({reason})") from error


def check_fresh(out: Path) -> None:
    """Before long work: raise RecordingError where a file is there that is not replaced."""
    if out.exists():
        raise _there(out)


def _there(out: Path) -> RecordingError:
    return RecordingError(f"{out}: exists already; name another file")


@contextmanager
def undone_on_failure(path: Path) -> Iterator[None]:
    """Where the block raises, the file at `path` is again what it was before, or is not there.

    For what is checked where it lies. What is written within has to come from `whole_file`; going
    back is a change of names, which a full disk does not hinder. Raises OSError.
    """
    target = os.path.realpath(path)
    before = _replaceable(target, follow=True)
    if _is_stream(path, before):
        yield
        return
    aside = None if before is None else _set_aside(target)
    try:
        yield
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(target) if aside is None else os.replace(aside, target)
        raise
    finally:
        if aside is not None:  # also where it is still the file: such a replacement does nothing
            with contextlib.suppress(OSError):
                os.unlink(aside)


def _set_aside(target: str) -> str:
    """A second name of a file; a copy on a disk without hard links."""
    aside = _part_beside(target)
    try:
        os.link(target, aside)
    except OSError:
        write_whole(Path(aside), Path(target).read_bytes())
    return aside


@contextmanager
def _written(path: Path, fresh: bool, follow: bool, mode: int | None) -> Iterator[BinaryIO]:
    """See `whole_file`; errors are those of the part."""
    if fresh and os.path.lexists(path):
        raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST))
    target = os.path.realpath(path) if follow else os.path.abspath(path)
    before = _replaceable(target, follow)
    if _is_stream(path, before):
        with os.fdopen(os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CLOEXEC), "wb") as stream:
            yield stream
        return
    part = _part_beside(target)
    descriptor = _made(part, 0o666 if mode is None else 0o600)
    try:
        with os.fdopen(descriptor, "wb") as out:
            if mode is not None:
                os.fchmod(descriptor, mode)
            elif before is not None:
                _like(descriptor, before)
            yield out
            out.flush()
            os.fsync(descriptor)
        _put(part, target, fresh)
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(part)
        raise
    _synced(os.path.dirname(target))


def _replaceable(target: str, follow: bool) -> os.stat_result | None:
    """The file that is there. Raises OSError for a folder, a loop, or one that is protected."""
    try:
        before = os.lstat(target)
    except FileNotFoundError:
        return None
    if stat.S_ISDIR(before.st_mode):
        raise IsADirectoryError(errno.EISDIR, "is a folder")
    if stat.S_ISLNK(before.st_mode):
        if follow:
            raise OSError(errno.ELOOP, os.strerror(errno.ELOOP))
        return None
    if stat.S_ISREG(before.st_mode) and not os.access(target, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
    return before


def _is_stream(path: Path, before: os.stat_result | None) -> bool:
    """Whether it is written to as it is: its place is a way to something, not a file's."""
    if before is not None and not stat.S_ISREG(before.st_mode):
        return True
    return os.path.abspath(path).startswith(_STREAMS) and not _in_memory(path)


def _in_memory(path: Path) -> bool:
    """Whether it is a file of the memory disk /dev/shm, which is a disk as others."""
    return os.path.abspath(path).startswith("/dev/shm/")


def _part_beside(target: str) -> str:
    return os.path.join(os.path.dirname(target), f".{secrets.token_hex(8)}{PART}")


def _made(part: str, mode: int) -> int:
    try:
        return os.open(part, _NEW, mode)
    except PermissionError as error:
        raise PermissionError(error.errno, "its folder is not writable") from error
    except FileNotFoundError as error:
        raise FileNotFoundError(error.errno, "no such folder") from error


def _like(descriptor: int, before: os.stat_result) -> None:
    """The permissions of the old file, and its owner where that is allowed."""
    if (before.st_uid, before.st_gid) != (os.geteuid(), os.getegid()):
        with contextlib.suppress(OSError):
            os.fchown(descriptor, before.st_uid, before.st_gid)
    with contextlib.suppress(OSError):
        os.fchmod(descriptor, stat.S_IMODE(before.st_mode))


def _put(part: str, target: str, fresh: bool) -> None:
    """Put the whole file in its place; a fresh one never over another that came meanwhile."""
    if not fresh:
        os.replace(part, target)
        return
    try:
        os.link(part, target)
    except FileExistsError:
        raise
    except OSError:  # a disk without hard links, as FAT
        if os.path.lexists(target):
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST)) from None
        os.replace(part, target)
        return
    os.unlink(part)


def _synced(folder: str) -> None:
    """Have the disk hold the new name as well; not every file system can be asked."""
    with contextlib.suppress(OSError):
        descriptor = os.open(folder or ".", os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


class TooLong(Exception):
    """A file has more bytes than its kind ever has."""


def read_plain(path: Path, most_bytes: int, follow: bool = True) -> bytes:
    """The bytes of a plain file, never waiting for a writer.

    follow: whether links may lead to it. Raises MissingFile (one line) when it cannot be read
    or is no plain file, TooLong.
    """
    content = None
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK | os.O_NOCTTY)
        with os.fdopen(descriptor, "rb") as file:
            if not follow and not _lies_at(descriptor, path):
                raise MissingFile(f"{path}: is reached through a link; name the file itself")
            if stat.S_ISREG(os.fstat(descriptor).st_mode):
                content = file.read(most_bytes + 1)
    except OSError as error:
        reason = error.strerror or str(error)
        raise MissingFile(f"{path}: cannot be read ({reason}); check the path") from error
    except ValueError as error:
        raise MissingFile(f"{str(path)!a}: is not a file name ({error})") from error
    if content is None:
        raise MissingFile(f"{path}: is no plain file; name one")
    if len(content) > most_bytes:
        raise TooLong
    return content


def _lies_at(descriptor: int, path: Path) -> bool:
    """Whether an open file is the one of that name, by the kernel's word: no link on the way."""
    return os.readlink(f"/proc/self/fd/{descriptor}") == os.path.abspath(path)
