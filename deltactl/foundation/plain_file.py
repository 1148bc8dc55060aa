"""Whole plain files, bounded: a pipe, a device or a disk image must hold nobody up."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from deltactl.foundation.errors import MissingFile


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
